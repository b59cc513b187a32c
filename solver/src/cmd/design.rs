//! `solver design`: the design problem of the common case, from one line.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail, ensure};
use mechanics::body::Body;
use scene::Scene;
use scene::config::{ProbeConfig, beside};

/// Part of a wanted value that counts as 1 in the objective.
const SCALE: f64 = 0.05;

/// The mold that is looked for beside the scene.
const MOLD: &str = "mold.toml";
/// The thinnest wall where nothing says another one [m].
const WALL: f64 = 1e-3;

/// Iterations of the level in which the whole wall moves along its normals.
const OFFSET: usize = 6;
/// Handles and iterations of the levels after it.
const LEVELS: [(usize, usize); 4] = [(1, 4), (3, 6), (6, 8), (12, 12)];

/// Write a design problem from one line: values that probes of a scene shall have, and the chamber that may move
///
/// Writes a commented design.toml beside the scene, which `solver optimize` takes as it is and which you can edit.
/// With --pressure, design.sim.toml is written, too: the scene with this pressure.
#[derive(clap::Args)]
pub struct Arguments {
    /// The scene, which has the probes
    scene: PathBuf,
    /// A probe of the scene and the value that it shall have, in its unit; can be given several times
    #[arg(long, value_name = "NAME=VALUE", required = true, value_parser = target)]
    probe: Vec<Target>,
    /// Tag whose surface may move; the only chamber of the scene if not given
    #[arg(long = "move", value_name = "TAG")]
    moved: Option<String>,
    /// The thinnest wall allowed between it and the outside [m]; casting.least_wall of a mold.toml beside the scene if not given,
    /// or 1 mm
    #[arg(long, value_name = "METRES")]
    wall: Option<f64>,
    /// The thinnest core allowed [m]; casting.least_core of a mold.toml beside the scene if not given
    #[arg(long, value_name = "METRES")]
    core: Option<f64>,
    /// Pressure of the chamber [Pa, gauge], in place of the scene's
    #[arg(long, value_name = "PASCALS", allow_negative_numbers = true)]
    pressure: Option<f64>,
    /// The design problem; design.toml beside the scene if not given
    #[arg(short, long)]
    output: Option<PathBuf>,
}

/// A probe by its name, and its wanted value in its unit.
#[derive(Clone)]
struct Target {
    probe: String,
    value: f64,
}

fn target(text: &str) -> Result<Target, String> {
    let wrong = || "expected NAME=VALUE, a number in the unit of the probe, as in bending=60";
    let (probe, value) = text.split_once('=').ok_or_else(wrong)?;
    let value: f64 = value.trim().parse().map_err(|_| wrong())?;
    if !value.is_finite() {
        return Err(wrong().to_owned());
    }
    Ok(Target { probe: probe.trim().to_owned(), value })
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let scene = Scene::read(&arguments.scene)?;
    let place = || arguments.scene.display().to_string();
    let casting = Casting::of(arguments)?;
    let moved = moved(arguments, &scene).with_context(place)?;
    let path = arguments
        .output
        .clone()
        .unwrap_or_else(|| beside(&arguments.scene, Path::new("design.toml")));
    let folder_of =
        |path: &Path| std::path::absolute(path).map(|path| path.parent().map(Path::to_owned));
    ensure!(
        folder_of(&path)? == folder_of(&arguments.scene)?,
        "{}: must lie beside the scene, {}",
        path.display(),
        arguments.scene.display()
    );
    let mut name = file_name(&arguments.scene)?;
    let mut files = Vec::new();
    if let Some(pressure) = arguments.pressure {
        let under = path.with_extension("sim.toml");
        files.push((under.clone(), pressed(&name, &moved, pressure, &scene).with_context(place)?));
        name = file_name(&under)?;
    }
    files.push((
        path.clone(),
        problem(arguments, &scene, &name, (&moved, &casting)).with_context(place)?,
    ));
    write(&files)?;
    let folder = beside(&path, Path::new("optimize"));
    log::info!("{}: solver optimize {} -o {}", path.display(), path.display(), folder.display());
    Ok(())
}

fn file_name(path: &Path) -> Result<String> {
    let name = path.file_name().and_then(|name| name.to_str());
    Ok(name.with_context(|| format!("{}: not a name in UTF-8", path.display()))?.to_owned())
}

/// What can be cast: as was asked for, or as the mold beside the scene says.
struct Casting {
    /// The thinnest wall [m].
    wall: f64,
    /// The thinnest core [m], if there is a limit.
    core: Option<f64>,
    /// Whether there is a mold.toml.
    has_mold: bool,
}

impl Casting {
    fn of(arguments: &Arguments) -> Result<Self> {
        for (key, asked) in [("--wall", arguments.wall), ("--core", arguments.core)] {
            let asked = asked.unwrap_or(1.0);
            ensure!(asked > 0.0 && asked.is_finite(), "{key} {asked}: must be positive, in metres");
        }
        let path = beside(&arguments.scene, Path::new(MOLD));
        let has_mold = path.exists();
        let mold: toml::Table = match has_mold {
            true => {
                let text = mesh::io::read_text(&path)?;
                text.parse().with_context(|| path.display().to_string())?
            }
            false => toml::Table::new(),
        };
        let number = |key: &str| {
            let found = mold.get("casting").and_then(|casting| casting.get(key));
            let least = found.and_then(toml::Value::as_float).filter(|least| *least > 0.0);
            ensure!(
                found.is_none() || least.is_some(),
                "{}: casting.{key} must be a number above 0, in metres",
                path.display()
            );
            Ok(least)
        };
        let wall = arguments.wall.or(number("least_wall")?).unwrap_or(WALL);
        let core = arguments.core.or(number("least_core")?);
        Ok(Self { wall, core, has_mold })
    }
}

/// The tag that may move.
fn moved(arguments: &Arguments, scene: &Scene) -> Result<String> {
    let chambers: Vec<&str> =
        scene.config.chamber.iter().flat_map(|c| c.on.all()).map(String::as_str).collect();
    let moved = match (&arguments.moved, &chambers[..]) {
        (Some(tag), _) => tag.clone(),
        (None, [only]) => (*only).to_owned(),
        (None, []) => bail!("the scene has no [[chamber]]; expected --move TAG"),
        (None, several) => {
            bail!("which chamber may move? Expected --move, one of {}", several.join(", "))
        }
    };
    scene.body.facets(&moved)?;
    Ok(moved)
}

/// The scene `name` with another pressure.
fn pressed(name: &str, moved: &str, pressure: f64, scene: &Scene) -> Result<String> {
    ensure!(pressure.is_finite(), "--pressure {pressure}: must be a number, in pascals");
    ensure!(
        scene.config.chamber.iter().any(|chamber| chamber.name == moved),
        "--pressure: \"{moved}\" is no [[chamber]] of the scene"
    );
    let (name, moved) = (quoted(name), quoted(moved));
    Ok(format!(
        "# The scene of the design at another pressure.\n\ninclude = {name}\n\n\
         [[chamber]]\non = {moved}\npressure = {pressure:?}    # gauge [Pa]\n"
    ))
}

/// The text of the design problem.
fn problem(
    arguments: &Arguments,
    scene: &Scene,
    name: &str,
    (moved, casting): (&str, &Casting),
) -> Result<String> {
    let against: Vec<_> = outside(&scene.body, moved)?.iter().map(|tag| quoted(tag)).collect();
    let tag = moved;
    let (name, moved) = (quoted(name), quoted(moved));
    let mut text = format!(
        "# What `solver design` wrote; edit it as you like. SI units; paths from this folder.\n\
         # All keys: solver schema design --markdown\n\n\
         scene = {name}\n\n\
         [optimizer]\n\
         stagnation = 2e-3               # a level ends when two iterations gain less than this\n\n\
         # What may move: first as a whole along its normals, then with more handles in each level.\n\
         [shape]\non = {moved}\n\n\
         [[shape.level]]\noffset = true\niterations = {OFFSET}\n"
    );
    for (handles, iterations) in LEVELS {
        writeln!(
            text,
            "\n[[shape.level]]\nhandles = {handles}\nmotion = \"rigid-and-offset\"\niterations = {iterations}"
        )?;
    }
    for Target { probe, value } in &arguments.probe {
        let unit = probe_of(scene, probe)?.kind().unit;
        let scale = scale(*value, unit);
        write!(
            text,
            "\n# The square of what is left to the wanted value, over `scale`.\n[[objective]]\nkind = \"probe\"\n\
             name = \"{probe}\"\nweight = 1.0\nprobe = \"{probe}\"\ntarget = {value:?}    # [{unit}]\n\
             scale = {scale:?}    # [{unit}]\n"
        )?;
    }
    if against.is_empty() {
        log::warn!("no tag lies off the rim of {moved}: walls are not kept");
    } else {
        let (wall, against) = (casting.wall, toml::Value::Array(against));
        write!(
            text,
            "\n# No wall is thinner.\n[[constraint]]\nkind = \"wall\"\nname = \"wall\"\n\
             on = {moved}\nagainst = {against}\nleast = {wall:?}    # [m]\n"
        )?;
    }
    if let Some(core) = casting.core {
        write!(
            text,
            "\n# No part of the core that makes the chamber is thinner.\n[[constraint]]\nkind = \"core\"\nname = \"core\"\n\
             on = {moved}\nleast = {core:?}    # [m]\n"
        )?;
    }
    write!(
        text,
        "\n# No crumpled walls, and none that pass through each other.\n[[objective]]\nkind = \"smoothness\"\n\
         name = \"smooth\"\nweight = 0.02\non = {moved}\n\n[[objective]]\nkind = \"clearance\"\n\
         name = \"clear\"\nweight = 1.0                    # [1/m^4]\nactivation = 5e-5               # [m]\n"
    )?;
    if casting.has_mold {
        write!(
            text,
            "\n# What cannot be cast so is no step, where the file names a method.\n[mold]\nconfig = \"{MOLD}\"\n"
        )?;
        let mut bodies = scene.body.parts.iter().filter_map(|part| part.name.as_ref());
        if let Some(body) = bodies.find(|body| tag.starts_with(&format!("{body}."))) {
            writeln!(text, "body = {}", quoted(body))?;
        }
    }
    Ok(text)
}

fn probe_of<'a>(scene: &'a Scene, name: &str) -> Result<&'a ProbeConfig> {
    let all = &scene.config.probe;
    all.iter().find(|probe| probe.name() == name).ok_or_else(|| match &all[..] {
        [] => anyhow!("the scene has no [[probe]]; add one, as solver list --probes shows"),
        _ => {
            let known: Vec<&str> = all.iter().map(ProbeConfig::name).collect();
            anyhow!(
                "--probe {name}: no [[probe]] of the scene is called that; there are: {}",
                known.join(", ")
            )
        }
    })
}

/// The difference that counts as 1: a part of the wanted value, or where that is nothing, what is seen.
fn scale(value: f64, unit: &str) -> f64 {
    let seen = match unit {
        "m" => 1e-3,
        "m³" => 1e-6,
        "N" => 0.1,
        _ => 1.0,
    };
    if value == 0.0 { seen } else { SCALE * value.abs() }
}

/// Tags of the boundary that do not touch `moved`: next to a common rim a wall is thin whatever its shape.
fn outside(body: &Body, moved: &str) -> Result<Vec<String>> {
    let own: BTreeSet<usize> = body.facets(moved)?.into_iter().flatten().collect();
    let is_off = |name: &&String| {
        let facets = body.facets(name).unwrap_or_default();
        *name != moved && facets.iter().flatten().all(|v| !own.contains(v))
    };
    Ok(body.used_tags().filter(is_off).cloned().collect())
}

/// Writes files of which none is there yet.
fn write(files: &[(PathBuf, String)]) -> Result<()> {
    if let Some((path, _)) = files.iter().find(|(path, _)| path.exists()) {
        bail!("{}: is there already; name another file with -o, or remove it", path.display());
    }
    for (path, text) in files {
        mesh::io::write_atomic(path, |out| out.write_all(text.as_bytes()))?;
    }
    Ok(())
}

/// A text as TOML has it.
fn quoted(text: &str) -> toml::Value {
    toml::Value::String(text.to_owned())
}
