//! Bodies that others made: meshes and CAD files in any unit, sound or not → a surface in patches.

pub mod fill;
pub mod repair;
pub mod source;
pub mod split;
pub mod weld;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail, ensure};
use mesh::bvh::SurfaceBvh;
use mesh::check::findings;
use mesh::measure::diagonal;
use mesh::rounding::Rounded;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3, check};
use nalgebra::{Matrix3, Rotation3};
use program::Unusable;
use program::units::Unit;

use crate::mesher::gmsh::CadOptions;
use crate::model::record::Record;
use crate::model::{Facts, LabelledSurface};
use repair::{Repair, parse_positive};
use source::Reader;

/// Triangles thinner than this are needles, which rounding to 32 bits may fold [diagonal].
const THIN: f64 = 1e-6;

/// A wall that is no farther from another surface is the same one, in other facets [diagonal].
const THERE: f64 = 1e-3;

/// A surface [m] with the patch of each triangle.
#[derive(Clone, Debug, Default)]
pub struct Patched {
    /// Any triangles.
    pub surface: SurfaceMesh,
    /// For each triangle an index into [`Patches`].
    pub patch: Vec<u32>,
}

impl Patched {
    /// Some of the triangles, with the vertices that they use.
    pub fn part(&self, triangles: &[usize]) -> Self {
        Self {
            surface: self.surface.part(triangles),
            patch: triangles.iter().map(|&t| self.patch[t]).collect(),
        }
    }

    /// More triangles, with vertices of their own.
    pub fn add(&mut self, more: Self) {
        self.surface.append(&more.surface);
        self.patch.extend(more.patch);
    }
}

/// Names of patches, each once.
#[derive(Debug, Default)]
pub struct Patches {
    names: Vec<String>,
}

impl Patches {
    /// The name of a patch.
    pub fn name(&self, patch: u32) -> &str {
        &self.names[patch as usize]
    }

    /// Names of which a body has no triangle.
    fn unused(&self, body: &Patched) -> Vec<String> {
        let used: BTreeSet<u32> = body.patch.iter().copied().collect();
        (0..).zip(&self.names).filter(|(i, _)| !used.contains(i)).map(|(_, n)| n.clone()).collect()
    }

    /// The index of a name.
    pub fn index(&mut self, name: &str) -> u32 {
        let known = self.names.iter().position(|n| n == name);
        let index = known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        u32::try_from(index).expect("there are fewer patches than triangles of a file")
    }
}

/// What is asked for.
#[derive(Debug, clap::Args)]
pub struct Request {
    /// .stl, .obj, .ply, .3mf, .step, .brep or .iges, or a tetrahedral .msh, whose boundary counts; of
    /// several the union
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Unit of files that state none; otherwise it is guessed by their size, and said
    #[arg(long)]
    unit: Option<Unit>,
    /// Files with what is taken away, such as chambers, or solids of the CAD file by their names or
    /// numbers
    #[arg(long, value_name = "FILE|SOLID", num_args = 1..)]
    subtract: Vec<String>,
    /// CAD: several solids that touch or cross are one body
    #[arg(long)]
    unite: bool,
    /// Factor of all lengths
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = parse_positive)]
    pub scale: f64,
    /// Turn about an axis through the origin, such as x=90 [deg]; several follow each other
    #[arg(long, value_name = "AXIS=DEG", value_parser = parse_turn)]
    turn: Vec<Matrix3<f64>>,
    /// Shift, after scale and turns [m]
    #[arg(long = "move", value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    shift: Option<Vec3>,
    /// Part patches at edges sharper than this [deg], such as 40
    #[arg(long, value_name = "DEG", value_parser = parse_positive)]
    split: Option<f64>,
    #[command(flatten)]
    repair: Repair,
    /// CAD: longest edge [m]
    #[arg(long, value_name = "M", value_parser = parse_positive)]
    edge_length: Option<f64>,
    /// CAD: how far triangles may be from the faces [m]
    #[arg(long, value_name = "M", default_value_t = 2e-5, value_parser = parse_positive)]
    pub chord: f64,
}

/// Reads, repairs and combines the files; `command` is what the user would write again with one more option.
pub fn import(request: &Request, command: &str) -> Result<LabelledSurface> {
    let (subtract, solids): (Vec<_>, Vec<_>) =
        request.subtract.iter().cloned().partition(|text| Path::new(text).exists());
    if let (Some(solid), false) = (solids.first(), request.files.len() == 1) {
        bail!(
            "--subtract {solid}: there is no such file, and several files whose solid it could be"
        );
    }
    let subtract: Vec<PathBuf> = subtract.into_iter().map(PathBuf::from).collect();
    let mut reader = Reader {
        unit: request.unit,
        cad: CadOptions {
            unit: None,
            numbers: BTreeMap::new(),
            edge_length: request.edge_length,
            chord: Some(request.chord),
            trust: false,
            subtract: solids,
            timeout: Duration::from_secs(request.repair.timeout),
        },
        unite: request.unite,
        command: command.to_owned(),
        guessed: None,
        facts: Facts::default(),
    };
    let mut record = Record::default();
    record.split = request.split;
    let mut patches = Patches::default();
    let several = request.files.len() + subtract.len() > 1;
    let mut solids = Vec::new();
    for file in request.files.iter().chain(&subtract) {
        let (raw, source) = reader.read(file, several, &mut patches)?;
        record.files.push(source);
        solids.push(request.repair.solid(raw, file, &mut patches, &mut record)?);
    }
    let cavities = solids.split_off(request.files.len());
    let solid = combined(solids, &cavities, &subtract, &mut record)?;
    let mut body = labels_of(&solid);
    let turn = request.turn.iter().fold(Matrix3::identity(), |all, turn| turn * all);
    let shift = request.shift.unwrap_or_default();
    body.surface.vertices.iter_mut().for_each(|p| *p = turn * *p * request.scale + shift);
    let body = written(body, request, &mut record)?;
    for patch in patches.unused(&body) {
        record.change(format!("nothing is left of patch {patch}"));
    }
    let body = match request.split {
        Some(angle) => split::split(body, angle, &mut patches)?,
        None => body,
    };
    let mut facts = reader.facts;
    facts.chord_error = facts.chord_error.map(|error| (error + record.moved) * request.scale);
    Ok(labelled(body, &patches, record, facts))
}

/// The union of bodies without the cavities.
fn combined(
    bodies: Vec<Solid>,
    cavities: &[Solid],
    subtract: &[PathBuf],
    record: &mut Record,
) -> Result<Solid> {
    let count = bodies.len();
    let body = bodies.into_iter().reduce(|a, b| a.union(&b));
    let mut body = body.ok_or_else(|| anyhow!("no file: at least one is needed"))?;
    if count > 1 {
        record.change(format!("union of {count} files: {:.4} cm3", body.volume() * 1e6));
    }
    for (cavity, file) in cavities.iter().zip(subtract) {
        let before = body.volume();
        body = body.difference(cavity);
        let taken = before - body.volume();
        if taken <= 1e-9 * before {
            return Err(nothing_taken(&body, cavity, file));
        }
        record.change(format!("{} subtracted: {:.4} cm3 less", file.display(), taken * 1e6));
    }
    ensure!(!body.is_empty(), "nothing is left of the body after subtracting");
    let pieces = body.decompose().len();
    if pieces > 1 {
        record.change(format!("it is {pieces} separate pieces"));
    }
    Ok(body)
}

/// Why subtracting took nothing away: the wall of a chamber that is there already lies on the surface of the body.
fn nothing_taken(body: &Solid, cavity: &Solid, file: &Path) -> anyhow::Error {
    let (surface, wall) = (SurfaceBvh::new(&body.to_surface()), cavity.to_surface().vertices);
    let near = THERE * diagonal(&wall);
    let there = wall.iter().filter(|p| surface.closest(p).distance < near).count();
    let (file, count) = (file.display(), wall.len());
    if 2 * there >= count {
        return anyhow!(
            "{file}: the body has this chamber already: {there} of its {count} vertices lie on the surface \
             of the body, and nothing is left to subtract; leave it out"
        );
    }
    anyhow!(
        "{file}: it does not meet the body, of which it should be subtracted; are both in the same \
         unit and place? `cad2fem picture` shows them together"
    )
}

/// The boundary of a solid whose labels are patches.
fn labels_of(solid: &Solid) -> Patched {
    let (surface, origins) = solid.to_surface_with_origin();
    Patched { surface, patch: origins.iter().map(|origin| origin.face).collect() }
}

/// The surface as a file keeps it; repaired once more where Booleans or rounding have left what is
/// not sound.
fn written(body: Patched, request: &Request, record: &mut Record) -> Result<Patched> {
    let rounded = round(&body);
    let found = check::check_surface(&rounded.surface);
    if found.is_empty() {
        return Ok(rounded);
    }
    record.change(format!("after all this it is not sound in 32 bits:{}", findings(&found)));
    let remade = round(&request.repair.remesh(&body, record)?);
    let found = check::check_surface(&remade.surface);
    if found.is_empty() {
        return Ok(remade);
    }
    Err(Unusable(format!("the body could not be repaired:{}", findings(&found))).into())
}

fn round(body: &Patched) -> Patched {
    let rounded = Rounded::new(&body.surface, THIN * diagonal(&body.surface.vertices));
    let patch = rounded.source.iter().map(|&t| body.patch[t]).collect();
    Patched { surface: rounded.surface, patch }
}

/// With the names that are in use, in the order in which they were read.
fn labelled(body: Patched, patches: &Patches, record: Record, facts: Facts) -> LabelledSurface {
    let mut used: Vec<u32> = body.patch.clone();
    used.sort_unstable();
    used.dedup();
    let region = body.patch.iter().map(|patch| used.binary_search(patch).ok()).collect();
    let names = used.iter().map(|&patch| patches.name(patch).to_owned()).collect();
    let import = Some(record);
    LabelledSurface {
        surface: body.surface,
        names,
        region,
        import,
        facts,
        ..LabelledSurface::default()
    }
}

/// Reads `x=90`.
fn parse_turn(text: &str) -> Result<Matrix3<f64>> {
    let needed = "AXIS=DEG is needed, such as x=90";
    let (axis, angle) = text.split_once('=').context(needed)?;
    let axis = match axis {
        "x" => Vec3::x_axis(),
        "y" => Vec3::y_axis(),
        "z" => Vec3::z_axis(),
        _ => bail!("{axis:?} is not x, y or z"),
    };
    let angle: f64 = angle.parse().with_context(|| format!("{angle:?} is not a number"))?;
    ensure!(angle.is_finite(), "{angle} is not an angle");
    // quarters of a turn without rounding
    let rotation = Rotation3::from_axis_angle(&axis, angle.to_radians()).into_inner();
    Ok(if angle % 90.0 == 0.0 { rotation.map(f64::round) } else { rotation })
}

/// Reads `0.01,0,-0.02`.
fn parse_point(text: &str) -> Result<Vec3> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|x| x.is_finite()) => Ok(Vec3::new(x, y, z)),
        _ => bail!("three numbers with commas are needed, found {text:?}"),
    }
}
