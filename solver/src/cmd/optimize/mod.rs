//! `solver optimize`: a design problem to a better body.

mod folder;
mod found;
mod starts;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use mesh::io::vtu;
use program::{Changes, FolderLock, InputFile, KeyPath, Settings, Unusable};
use reports::{Castable, Designed, Ended, Inputs, Iteration, Optimization, Remeshed};
use scene::config::{DesignConfig, LevelConfig, beside};
use scene::{ObjectiveBuilder, Scene, log_share};

use self::folder::{
    failed, forget, forget_failure, forget_start, is_kept_before_a_level, outdated, remove,
};
use self::found::Found;
use crate::optimize::{
    CASTABLE, Cascade, Finished, History, LATEST, Meshes, Molding, mesh_file, write_bodies,
};
use crate::report::crossing::Crossing;
use crate::report::{results, summary};

/// A smaller fall of the objective is hardly a design [1].
const LITTLE: f64 = 0.01;
/// A larger difference of the objective between two meshes of the design, over what was gained, says that its elements are
/// poor [1].
const OFF: f64 = 0.1;

/// Optimise shapes of chambers and pressures over time
///
/// Writes to the output folder: design.msh (tagged; design.NAME.msh for each of
/// several bodies), pressures.toml and parameters.toml (designed loads, as tables of a scene),
/// history.jsonl (one line per accepted iteration), report.json, and result.vtu (the
/// design at the end). Killed at any moment, the same command continues where it was.
#[derive(clap::Args)]
pub struct Arguments {
    /// The design problem
    design: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Begin anew, whatever the folder holds
    #[arg(long)]
    restart: bool,
    /// Design from so many starts side by side, the shape as modelled and others that handles and loads are moved to at random;
    /// the best is kept, and starts.csv has a line for each
    #[arg(long, value_name = "COUNT", default_value_t = 1)]
    starts: usize,
    /// The number of the start, of which 1 is the shape as modelled
    #[arg(long, hide = true, default_value_t = 1, conflicts_with = "starts")]
    start: usize,
    #[command(flatten)]
    changes: Changes,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let Problem { file, design, scene } = read(&arguments.design, &[], &arguments.changes)?;
    log_share(&scene.body);
    let molding = file.checked(|_| Molding::new(&arguments.design, &design, &scene.body))?;
    let meshes = file.checked(|_| meshes(arguments, &design, &scene))?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    ensure!(arguments.starts > 0, "--starts 0: expected 1 or more");
    let best = (arguments.starts > 1).then(|| {
        file.checked(|_| starts::check(&design))?;
        starts::best(arguments)
    });
    let best = best.transpose()?;
    let objectives =
        file.checked(|_| ObjectiveBuilder::new(&arguments.design, &design.objective, &scene))?;
    let inputs = hash_inputs(&file, &design, &scene)?;
    if arguments.restart || outdated(folder, &inputs)? {
        if folder.join("report.json").exists() && !failed(folder)? {
            log::warn!("{}: the finished design there is replaced", folder.display());
        }
        forget(folder)?;
    }
    if is_kept_before_a_level(folder)? {
        log::info!("{}: is finished, before a level that cannot begin", folder.display());
        return Ok(());
    }
    forget_failure(folder)?;
    if let Some(best) = best {
        forget(folder)?;
        starts::take_over(&best, folder)?;
    }
    let cascade = Cascade {
        scene: &scene,
        design: &design,
        meshes,
        objectives: &objectives,
        molding,
        folder: folder.clone(),
        start: arguments.start,
        inputs,
    };
    let finished = cascade.run().map_err(|error| {
        // the first error is the one that counts
        let _ = forget_start(folder);
        file.place(error)
    })?;
    write(folder, &scene, &finished)?;
    let (level, evaluation) = &finished.last;
    let crossing = level.crossing(evaluation);
    let (inputs, set) = provenance(folder, &file, &design, &scene)?;
    let found = Found { finished: &finished, scene: &scene, design: &design };
    let mut designed = found.designed(History::new(folder).read()?, inputs, set, start);
    designed.crossing = crossing.as_ref().map(Crossing::report);
    designed.remeshed = remeshed(&cascade, &finished, &designed);
    let violated = level.violated(evaluation);
    let status = match (&crossing, &violated) {
        (Some(_), _) => Ended::SurfacesCrossed,
        (None, Some(_)) => Ended::NotKept,
        (None, None) => found.ended(),
    };
    let report = Optimization {
        status,
        usable: crossing.is_none() && violated.is_none(),
        designed: Some(designed.clone()),
        failed: None,
    };
    results::write_report(folder, &report)?;
    let [before, after] =
        [designed.objective_before, designed.objective_after].map(|j| j.unwrap_or(f64::NAN));
    let fall = (before - after) / before.abs();
    // to keep its bounds a design may have to give away some of its objective
    let is_better = fall > 0.0 || finished.began_outside;
    if finished.began_outside {
        log::info!(
            "the objective went from {before:.4e} to {after:.4e}; the start violated what the design keeps"
        );
    } else if fall < LITTLE {
        log::warn!(
            "the objective fell by {:.1} % only: the design is hardly better than the start; see \
             the terms and the reasons in {}",
            100.0 * fall,
            folder.join("report.json").display()
        );
    } else {
        log::info!("{}", summary::of_design(designed.probes.as_ref(), fall));
    }
    for (name, kept) in &designed.constraints {
        if let Some(said) = summary::of_constraint(name, kept) {
            log::info!("{said}");
        }
    }
    if let Some(end) = designed.levels.iter().rev().find(|end| end.ending == status)
        && matches!(status, Ended::StillFalling | Ended::Jammed)
    {
        log::warn!("level {} {}: {}", end.level, end.ending.in_words(), end.why);
    }
    if let Some(crossing) = crossing {
        let design = arguments.design.display();
        return Err(Unusable(format!("{design}: {}", crossing.in_words())).into());
    }
    if let Some(violated) = violated {
        let design = arguments.design.display();
        return Err(Unusable(format!("{design}: the design does not keep {violated}")).into());
    }
    if !is_better {
        return Err(Unusable(format!(
            "{}: no step lowered the objective; see the reasons in {}",
            arguments.design.display(),
            folder.join("report.json").display()
        ))
        .into());
    }
    Ok(())
}

/// The design with a re-meshed interior.
fn remeshed(cascade: &Cascade, finished: &Finished, designed: &Designed) -> Option<Remeshed> {
    let again = match cascade.again(finished) {
        Ok(again) => again?,
        Err(error) => {
            log::warn!("with a re-meshed interior the design was not simulated: {error:#}");
            return None;
        }
    };
    let (own, other) = (finished.last.1.objective, again.objective);
    let gain = (designed.objective_before.unwrap_or(f64::NAN) - own).abs();
    let probes: Vec<String> = designed
        .probes
        .iter()
        .flatten()
        .filter_map(|(name, probe)| {
            Some(format!(", {name} {}", summary::quantity(*again.probes.get(name)?, &probe.unit)))
        })
        .collect();
    let said = format!(
        "with a re-meshed interior the objective is {other:.4e} in place of {own:.4e}{}",
        probes.concat()
    );
    match (other - own).abs() > OFF * gain {
        true => log::warn!("{said}: elements of the design are poor; a finer mesh tells more"),
        false => log::info!("{said}"),
    }
    Some(Remeshed { objective: Some(other), probes: reports::numbers(&again.probes) })
}

/// A design problem and its scene.
pub struct Problem {
    pub file: Settings,
    pub design: DesignConfig,
    pub scene: Scene,
}

/// A design file and its scene, perhaps with another mesh and other values.
pub fn read(path: &Path, others: &[super::OtherMesh], changes: &Changes) -> Result<Problem> {
    let (own, of_scene) = changes.own_and_scene();
    let file = DesignConfig::settings(path, &own)?;
    let design = DesignConfig::of(&file)?;
    let scene = Scene::read_with(&beside(path, &design.scene), others, &of_scene)?;
    scene.warn_of_growth();
    Ok(Problem { file, design, scene })
}

/// The body on the meshes of the scene and of the levels.
fn meshes(arguments: &Arguments, design: &DesignConfig, scene: &Scene) -> Result<Meshes> {
    let (_, of_scene) = arguments.changes.own_and_scene();
    Meshes::new(&scene.body, design, |level| {
        let levels = if design.shape.is_some() { "shape.level" } else { "level" };
        check_body(level, &KeyPath::list(levels), scene)?;
        let path = level.mesh.iter().map(|path| beside(&arguments.design, path));
        let others: Vec<_> = path.map(|path| (level.body.clone(), path)).collect();
        Ok(Scene::read_with(&scene.path, &others, &of_scene)?.body)
    })
}

/// The mesh of a level is of a body that the scene has.
fn check_body(level: &LevelConfig, levels: &KeyPath, scene: &Scene) -> Result<()> {
    let refused = |word: &str, what: String| levels.clone().with(KeyPath::word(word)).told(what);
    let names: Vec<&str> = scene.body.parts.iter().filter_map(|p| p.name.as_deref()).collect();
    match level.body.as_deref() {
        Some(body) if names.is_empty() => {
            let what = "the scene has only one body; expected none";
            bail!(refused(body, format!("level: body = \"{body}\": {what}")))
        }
        Some(body) if !names.contains(&body) => {
            let known = names.join(", ");
            bail!(refused(body, format!("level: body = \"{body}\": expected one of {known}")))
        }
        None if names.len() > 1 => {
            let known = names.join(", ");
            let what = format!("level: mesh without body; expected body = one of {known}");
            bail!(refused("mesh", what))
        }
        _ => Ok(()),
    }
}

/// A checkpoint is only good for the problem it was made for.
fn hash_inputs(file: &Settings, design: &DesignConfig, scene: &Scene) -> Result<String> {
    let mut hashes = vec![file.hash(), scene.file.hash()];
    for part in &scene.parts {
        hashes.push(program::sha256_file(&part.mesh_path)?);
    }
    for path in named_files(file, design).iter().flatten() {
        hashes.push(program::sha256_file(path)?);
    }
    Ok(hashes.join(" "))
}

/// The meshes of levels and the files of objectives that a design names beside its scene.
fn named_files(file: &Settings, design: &DesignConfig) -> [BTreeSet<PathBuf>; 2] {
    let at = file.file().path;
    let all = |paths: Vec<PathBuf>| paths.iter().map(|path| beside(&at, path)).collect();
    let meshes = design.levels().into_iter().filter_map(|level| level.mesh).collect();
    let targets = design.objective.iter().flat_map(|term| term.files()).map(PathBuf::from);
    [all(meshes), all(targets.collect())]
}

fn write(folder: &Path, scene: &Scene, finished: &Finished) -> Result<()> {
    write_bodies(folder, "design", scene, &finished.body)?;
    let is_refused = matches!(
        History::new(folder).read()?.last(),
        Some(Iteration { mold: Some(Castable::Refused { .. }), .. })
    );
    for part in &scene.body.parts {
        let name = part.name.as_deref();
        remove(folder, &[&mesh_file(LATEST, name)])?;
        let castable = mesh_file(CASTABLE, name);
        if !is_refused {
            remove(folder, &[&castable])?;
        } else if folder.join(&castable).exists() {
            log::warn!(
                "the design cannot be cast; the last shape that can is {}",
                folder.join(&castable).display()
            );
        }
    }
    let (level, evaluation) = &finished.last;
    vtu::write_vtu(&folder.join("result.vtu"), &level.grid(evaluation))?;
    write_pressures(folder, finished)?;
    write_parameters(folder, finished)
}

/// The designed parameters and numbers as the tables that a scene would have.
fn write_parameters(folder: &Path, finished: &Finished) -> Result<()> {
    let all = finished.last.0.map().parameters(&finished.theta);
    if all.is_empty() {
        return Ok(());
    }
    let (numbers, parameters): (BTreeMap<_, _>, BTreeMap<_, _>) =
        all.into_iter().partition(|(name, _)| name.contains('.'));
    let tables = [("parameters", parameters), ("numbers", numbers)];
    let tables = tables.into_iter().filter(|(_, table)| !table.is_empty());
    let text = toml::to_string(&tables.collect::<BTreeMap<_, _>>())?;
    mesh::io::write_atomic(&folder.join("parameters.toml"), |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// The designed pressures as the tables that a scene would have.
fn write_pressures(folder: &Path, finished: &Finished) -> Result<()> {
    let map = finished.last.0.map();
    let number = |list: &[f64]| toml::Value::from(list.to_vec());
    let one = |(on, values): (String, Vec<f64>)| {
        let mut curve = toml::Table::new();
        curve.insert("t".to_owned(), number(&finished.last.1.runs[0].states.times));
        curve.insert("value".to_owned(), number(&values));
        let mut table = toml::Table::new();
        table.insert("on".to_owned(), on.into());
        table.insert("pressure".to_owned(), curve.into());
        toml::Value::Table(table)
    };
    let tables: Vec<toml::Value> = map.pressures(&finished.theta).into_iter().map(one).collect();
    if tables.is_empty() {
        return Ok(());
    }
    let text = toml::to_string(&toml::Table::from_iter([("chamber".to_owned(), tables.into())]))?;
    mesh::io::write_atomic(&folder.join("pressures.toml"), |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// The files that a design was made from, and the values that were set.
fn provenance(
    folder: &Path,
    file: &Settings,
    design: &DesignConfig,
    scene: &Scene,
) -> Result<(Inputs, Vec<String>)> {
    let (inputs, set) = results::provenance(folder, Some(file), scene)?;
    let hashed = |paths: BTreeSet<PathBuf>| -> Result<Vec<InputFile>> {
        Ok(paths.iter().map(|path| InputFile::new(path, folder)).collect::<Result<_, _>>()?)
    };
    let [level_meshes, targets] = named_files(file, design).map(hashed);
    Ok((Inputs { level_meshes: level_meshes?, targets: targets?, ..inputs }, set))
}
