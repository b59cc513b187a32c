//! Bodies: their meshes, placed and tagged.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use mesh::{SurfaceMesh, Tags, TetMesh, Vec3};

use super::document::Key;
use super::planar;
use super::selection::{Facet, UNSELECTED, select};

/// Tag of the front and back of a slab.
pub const FACES: &str = "s_planar";

/// Thickness of slabs in mean edges. A field may vary over the depth of a slab,
/// to which edges at an angle belong, and in the plane it may not: at one edge
/// the walker of Gjoka et al. 2024 moves 1e-3 differently before it touches the
/// ground, at a tenth of it 9e-5, at a hundredth 1e-6.
pub const THIN: f64 = 0.1;

/// A body of the scene.
pub struct Solid {
    /// What our scene calls it.
    pub name: String,
    /// Id of its material.
    pub volume: i64,
    /// In metres, where it belongs.
    pub mesh: TetMesh,
    /// Names are those of [`tag`].
    pub tags: Tags,
    /// The number of the tag of each id.
    pub ids: BTreeMap<i64, u32>,
}

/// A rigid surface of the scene.
pub struct Obstacle {
    /// What our scene calls it.
    pub name: String,
    /// The id, if it is the same everywhere.
    pub id: Option<i64>,
    /// In metres, where it belongs.
    pub surface: SurfaceMesh,
}

/// What a scene is made of.
#[derive(Default)]
pub struct Geometry {
    /// The bodies.
    pub solids: Vec<Solid>,
    /// The rigid surfaces.
    pub obstacles: Vec<Obstacle>,
    /// Thickness of the slabs of a plane scene [m].
    pub thickness: Option<f64>,
    /// Whether tags have the name of their body in front.
    pub several: bool,
}

impl Geometry {
    /// A tag as our scene calls it.
    pub fn on(&self, solid: &Solid, tag: &str) -> String {
        if self.several { format!("{}.{tag}", solid.name) } else { tag.to_owned() }
    }
}

/// The tag of a selection.
pub fn tag(id: i64) -> String {
    if id == UNSELECTED { "unselected".to_owned() } else { format!("s{id}") }
}

/// A body as it was read.
enum Read {
    Space(TetMesh),
    Plane(SurfaceMesh),
}

/// Reads, places and tags all bodies. Slabs are `thickness` thick, or else
/// [`THIN`] times the mean edge of the body where it is smallest [m].
pub fn read(geometries: &Key, thickness: Option<f64>) -> Result<Geometry> {
    let (mut geometry, mut bodies) = (Geometry::default(), Vec::new());
    let (mut names, mut planes) = (Vec::new(), Vec::new());
    for key in geometries.items() {
        if key.optional("enabled", Key::flag)? == Some(false) {
            key.leave("\"enabled\" is false");
            continue;
        }
        if let Some(kind) = key.get("type").filter(|kind| kind.value != "mesh") {
            return Err(kind.wrong(&format!("unknown kind {}; expected \"mesh\"", kind.value)));
        }
        let file = key.need("mesh", "the file of the body")?;
        let path = file.file()?;
        if !path.is_file() {
            return Err(file.wrong(&format!(
                "there is no file {}\n  the mesh is part of the scene: put it there, or write \
                 where it is",
                path.display()
            )));
        }
        let name = unused(&path, &mut names);
        if key.optional("is_obstacle", Key::flag)? == Some(true) {
            geometry.obstacles.push(obstacle(&key, &file, &path, name)?);
            continue;
        }
        let mut read = body(&path)?;
        match &mut read {
            Read::Space(mesh) => place(&key, &mut mesh.vertices, 3)?,
            Read::Plane(plane) => {
                place(&key, &mut plane.vertices, 2)?;
                planes.push(mesh::measure::mean_edge(&plane.vertices, &plane.triangles));
            }
        }
        bodies.push((key, name, read));
    }
    if !planes.is_empty() {
        if planes.len() < bodies.len() || !geometry.obstacles.is_empty() {
            return Err(geometries.wrong("plane bodies beside others: expected all of one kind"));
        }
        // of a floor of two triangles, edges are no measure
        let finest = planes.into_iter().fold(f64::INFINITY, f64::min);
        geometry.thickness = Some(thickness.unwrap_or(THIN * finest));
    }
    for (key, name, read) in bodies {
        geometry.solids.push(solid(&key, name, read, geometry.thickness.unwrap_or_default())?);
    }
    if geometry.solids.is_empty() {
        return Err(geometries.wrong("no body: expected one that is no obstacle"));
    }
    Ok(geometry)
}

/// The name of a file in letters that tags may have, which no other body has.
fn unused(path: &Path, names: &mut Vec<String>) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let stem: String = stem.chars().map(plain).collect();
    let numbered = (2..).map(|number| format!("{stem}_{number}"));
    let mut all = std::iter::once(stem.clone()).chain(numbered);
    let name = all.find(|name| !names.contains(name)).expect("numbers do not end");
    names.push(name.clone());
    name
}

fn body(path: &Path) -> Result<Read> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
        return Ok(Read::Plane(planar::read(path)?));
    }
    Ok(Read::Space(mesh::io::read_tets_of_any_unit(path)?.mesh))
}

/// x ↦ scale x + translation.
fn place(key: &Key, vertices: &mut [Vec3], dimension: usize) -> Result<()> {
    if let Some(refinements) = key.get("n_refs")
        && refinements.count()? != 0
    {
        return Err(refinements.wrong(&format!(
            "{}: bodies are not refined here; expected 0 and a fine mesh",
            refinements.value
        )));
    }
    let Some(transformation) = key.get("transformation") else { return Ok(()) };
    for name in ["rotation", "dimensions"] {
        let is_zero = |key: &Key| key.items().iter().all(|k| k.value.as_f64() == Some(0.0));
        if let Some(other) = transformation.get(name).filter(|other| !is_zero(other)) {
            let what = "only \"scale\" and \"translation\" are known: apply it to the mesh";
            return Err(other.wrong(what));
        }
    }
    // z of a plane body stays 0
    let vector = |numbers: Vec<f64>| Vec3::from_fn(|k, _| *numbers.get(k).unwrap_or(&0.0));
    let mut scale = Vec3::new(1.0, 1.0, 1.0);
    if let Some(given) = transformation.get("scale") {
        let factors = match given.value.as_f64() {
            Some(factor) => vec![factor; dimension],
            None => given.numbers(dimension)?,
        };
        if let Some(factor) = factors.iter().find(|factor| !(factor.is_finite() && **factor > 0.0))
        {
            return Err(given.wrong(&format!("{factor}: expected factors greater than 0")));
        }
        scale = vector(factors);
    }
    let shift = transformation.get("translation").map(|given| given.numbers(dimension));
    let shift = shift.transpose()?.map_or_else(Vec3::zeros, vector);
    vertices.iter_mut().for_each(|v| *v = scale.component_mul(v) + shift);
    Ok(())
}

fn solid(key: &Key, name: String, read: Read, thickness: f64) -> Result<Solid> {
    let volume = key.optional("volume_selection", Key::id)?.unwrap_or(0);
    let dimension = if matches!(read, Read::Plane(_)) { 2 } else { 3 };
    let (mesh, facets, faces) = match read {
        Read::Space(mesh) => {
            let facets = mesh::topology::boundary(&mesh).facets.into_iter().map(|corners| Facet {
                corners,
                source: mesh::facet_key(corners).to_vec(),
                center: corners.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 3.0,
            });
            let facets = facets.collect();
            (mesh, facets, Vec::new())
        }
        Read::Plane(plane) => planar::extruded(&plane, thickness),
    };
    let bounds = mesh::measure::bounds(&mesh.vertices);
    let selection = key.get("surface_selection");
    let found = select(selection.as_ref(), &facets, dimension, bounds)?;
    let mut ids: BTreeMap<i64, u32> = found.iter().map(|&id| (id, 0)).collect();
    ids.values_mut().zip(1..).for_each(|(own, number)| *own = number);
    let of_faces = (!faces.is_empty()).then(|| FACES.to_owned());
    let mut tags = Tags::new(ids.keys().map(|&id| tag(id)).chain(of_faces).collect());
    facets.iter().zip(&found).for_each(|(facet, id)| tags.set(facet.corners, ids[id]));
    let last = ids.len() as u32 + 1;
    faces.into_iter().for_each(|corners| tags.set(corners, last));
    Ok(Solid { name, volume, mesh, tags, ids })
}

fn obstacle(key: &Key, file: &Key, path: &Path, name: String) -> Result<Obstacle> {
    let mut surface = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("msh")) {
        let mesh = mesh::io::read_tets_of_any_unit(path)?.mesh;
        mesh::topology::boundary(&mesh).surface(&mesh).0
    } else {
        mesh::io::read_surface(path).map_err(|e| file.wrong(&e.to_string()))?
    };
    place(key, &mut surface.vertices, 3)?;
    let id = key.get("surface_selection").filter(|k| k.value.is_i64());
    let id = id.map(|k| k.id()).transpose()?;
    Ok(Obstacle { name, id, surface })
}
