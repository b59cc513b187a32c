//! Bodies that others made: meshes and CAD files in any unit, sound or not → a surface in patches.

pub mod fill;
pub mod repair;
pub mod source;
pub mod split;
pub mod weld;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, ensure};
use mesh::bvh::SurfaceBvh;
use mesh::measure::diagonal;
use mesh::rounding::Rounded;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3, check};
use nalgebra::Matrix3;
use program::Unusable;

use crate::model::record::Record;
use crate::model::{Facts, LabelledSurface};
use crate::report::findings;
use repair::Repair;
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
#[derive(Debug)]
pub struct Request {
    /// Files of which the union is taken.
    pub files: Vec<PathBuf>,
    /// Files that are subtracted from it.
    pub subtract: Vec<PathBuf>,
    /// How files are read.
    pub reader: Reader,
    /// How what is not sound is repaired.
    pub repair: Repair,
    /// Factor of all lengths [1].
    pub scale: f64,
    /// Turns about the axes through the origin.
    pub turn: Matrix3<f64>,
    /// Shift after scaling and turning [m].
    pub shift: Vec3,
    /// Angle between triangles from which on an edge parts patches of meshes [deg].
    pub split: Option<f64>,
}

/// Reads, repairs and combines the files.
pub fn import(request: &mut Request) -> Result<LabelledSurface> {
    let mut record = Record::default();
    record.split = request.split;
    let mut patches = Patches::default();
    let several = request.files.len() + request.subtract.len() > 1;
    let mut solids = Vec::new();
    let files = request.files.iter().chain(&request.subtract).cloned().collect::<Vec<_>>();
    for file in &files {
        let (raw, source) = request.reader.read(file, several, &mut patches)?;
        record.files.push(source);
        solids.push(request.repair.solid(raw, file, &mut patches, &mut record)?);
    }
    let cavities = solids.split_off(request.files.len());
    let solid = combined(solids, &cavities, request, &mut record)?;
    let mut body = labels_of(&solid);
    body.surface.vertices.iter_mut().for_each(|p| {
        *p = request.turn * *p * request.scale + request.shift;
    });
    let body = written(body, request, &mut record)?;
    for patch in patches.unused(&body) {
        record.change(format!("nothing is left of patch {patch}"));
    }
    let body = match request.split {
        Some(angle) => split::split(body, angle, &mut patches)?,
        None => body,
    };
    let mut facts = std::mem::take(&mut request.reader.facts);
    facts.chord_error = facts.chord_error.map(|error| (error + record.moved) * request.scale);
    Ok(labelled(body, &patches, record, facts))
}

/// The union of bodies without the cavities.
fn combined(
    bodies: Vec<Solid>,
    cavities: &[Solid],
    request: &Request,
    record: &mut Record,
) -> Result<Solid> {
    let count = bodies.len();
    let body = bodies.into_iter().reduce(|a, b| a.union(&b));
    let mut body = body.ok_or_else(|| anyhow!("no file: at least one is needed"))?;
    if count > 1 {
        record.change(format!("union of {count} files: {:.4} cm3", body.volume() * 1e6));
    }
    for (cavity, file) in cavities.iter().zip(&request.subtract) {
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
