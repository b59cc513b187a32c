//! Closed surface → tetrahedra: checks before and after the mesher.

pub mod cache;
pub mod config;
pub mod fragments;
pub mod planar;

use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use mesh::check::findings;
use mesh::check::{check_surface, check_tets, coincident, orient_by_nesting, run};
use mesh::improve::{improve_around, improve_interior};
use mesh::measure::{Quality, area, enclosed_volume, farthest, quality, tet_volume, volume};
use mesh::topology::{boundary, components};
use mesh::walls::thinner;
use mesh::{SurfaceMesh, TetMesh, Vec3};
use program::Unusable;
use serde::Serialize;

use crate::mesher::layers::{Layers, exact_facets};
use crate::mesher::python::{Package, Python};
use crate::mesher::{Options, TetMesher};
use crate::tetmesh::cache::{Cache, key};
use crate::tetmesh::fragments::{open_pinches, remove_fragments, remove_spikes};
use crate::tetmesh::planar::flatten;

/// Points at which distances between surfaces are measured.
const SAMPLES: usize = 60_000;

/// Part of the cache key; changes whenever the steps after the mesher change.
const REVISION: u32 = 7;

/// How often a mesher may try.
const ATTEMPTS: u32 = 3;

/// The envelope of the next try of a mesher [that of the one before]. Of 16 bodies three left theirs, by
/// 3 % at most; the blank then has 3295 tetrahedra, with half the envelope 5337.
const FINER: f64 = 0.7;

/// The edges of the last try of a mesher [those wanted]: a ribbed body was meshed with half of them, and not with
/// seven tenths.
const SHORTER: f64 = 0.5;

/// How a surface is to be meshed.
pub struct Request<'a> {
    /// What runs the mesher.
    pub python: Python,
    /// Who may mesh, in the order in which they are tried.
    pub meshers: Vec<&'a dyn TetMesher>,
    /// What is asked of it.
    pub options: Options,
    /// Passes of our own improvement afterwards; none where a mesher has moved surfaces inside.
    pub improve_passes: usize,
    /// Surfaces inside that become facets.
    pub layers: Layers,
    /// Where meshes are kept.
    pub cache: Option<Cache>,
    /// Longest time the mesher may take.
    pub timeout: Duration,
}

/// What was made, and how good it is.
#[derive(Debug, Serialize)]
pub struct Outcome {
    /// Mesher and its version.
    pub mesher: String,
    /// What was asked of it.
    pub options: Options,
    /// Passes of our own improvement.
    pub improve_passes: usize,
    /// Triangles of surfaces inside that it was asked to keep.
    #[serde(skip_serializing_if = "is_none")]
    pub triangles_inside: usize,
    /// Whether the mesh came from the cache.
    pub cached: bool,
    /// Why earlier tries were not usable; not known of a mesh from the cache.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// Vertices.
    pub vertices: usize,
    /// Tetrahedra.
    pub tets: usize,
    /// Triangles of the boundary.
    pub boundary_facets: usize,
    /// Connected shells of the boundary.
    pub shells: usize,
    /// Volume of the tetrahedra [m³].
    pub volume: f64,
    /// Volume enclosed by the input [m³].
    pub input_volume: f64,
    /// Largest allowed difference of the two, area × envelope [m³].
    pub volume_tolerance: f64,
    /// Largest distance of the boundary from the input [envelope].
    pub hausdorff_to_input: f64,
    /// Largest distance of the input from the boundary [envelope].
    pub hausdorff_from_input: f64,
    /// Quality of the elements.
    pub quality: Quality,
    /// Time to make or fetch and to verify the mesh [s].
    pub wall_s: f64,
}

/// Checks that a surface bounds a body, and orients its shells by nesting: outer
/// shells outward, cavities inward. Reversing a cavity is
/// logged. An outer shell is reversed only if `orient`, since it hints at a mistake.
pub fn prepare(surface: &mut SurfaceMesh, orient: bool) -> Result<()> {
    let found = run(surface, &["closed", "manifold", "intersecting"]);
    if !found.is_empty() {
        bail!(
            "it does not bound a body:{}\n  repair it where it was made; `cad2fem info` shows all \
             findings",
            findings(&found)
        );
    }
    let given = surface.clone();
    orient_by_nesting(surface);
    for shell in components(&given.triangles) {
        let turned = shell.iter().filter(|&&t| given.triangles[t] != surface.triangles[t]).count();
        if turned == 0 {
            continue;
        }
        let (volume, triangles) = (enclosed_volume(&surface.part(&shell)), shell.len());
        let kind = if volume > 0.0 { "outer surface" } else { "cavity" };
        let what = format!(
            "{turned} of {triangles} triangles of the {kind} of {:.4} cm3 face the wrong way",
            volume.abs() * 1e6
        );
        ensure!(
            volume < 0.0 || orient,
            "{what}: an inward-facing body is often a mistake; --orient turns it"
        );
        log::info!("{what}: turned");
    }
    Ok(())
}

/// Fills a prepared surface with tetrahedra: by the first of the meshers that makes a usable mesh.
pub fn tetrahedralize(surface: &SurfaceMesh, request: &Request) -> Result<(TetMesh, Outcome)> {
    let mut refused: Vec<(&str, anyhow::Error)> = Vec::new();
    for &mesher in &request.meshers {
        if let Some((name, error)) = refused.last() {
            log::warn!("{name}: {error:#}; {} is tried", mesher.name());
        }
        match tetrahedralize_by(mesher, surface, request) {
            Ok((mesh, mut outcome)) => {
                let earlier = refused.iter().map(|(name, error)| format!("{name}: {error:#}"));
                outcome.refused.splice(0..0, earlier);
                return Ok((mesh, outcome));
            }
            Err(error) => refused.push((mesher.name(), error)),
        }
    }
    let others: Vec<String> = refused
        .split_off(1.min(refused.len()))
        .into_iter()
        .map(|(name, error)| format!("{name}: {error:#}"))
        .collect();
    let (name, error) = refused.pop().context("no mesher is to be tried")?;
    Err(if others.is_empty() {
        error
    } else {
        error.context(format!("no mesher makes a usable mesh; {}; {name}", others.join("; ")))
    })
}

/// As [`tetrahedralize`], by one mesher.
fn tetrahedralize_by(
    mesher: &dyn TetMesher,
    surface: &SurfaceMesh,
    request: &Request,
) -> Result<(TetMesh, Outcome)> {
    let start = Instant::now();
    let package = request.python.first_of(mesher.packages())?;
    let name = format!("{} ({} {})", mesher.name(), package.name, package.version);
    let (all, inside) = request.layers.beside(surface);
    let asked = (&request.options, request.improve_passes, inside);
    let key = key(&all, &(REVISION, &name, mesher.script(), asked))?;
    let kept = request.cache.as_ref().and_then(|cache| cache.get(&key));
    let cached = kept.is_some();
    let (mesh, mut outcome) = match kept {
        Some(mesh) => {
            let outcome = verify(&mesh, surface, request, name)?;
            (mesh, outcome)
        }
        None => make(mesher, &package, surface, request, &name)?,
    };
    if let (Some(cache), false) = (&request.cache, cached)
        && let Err(error) = cache.put(&key, &mesh)
    {
        log::warn!("the mesh is not kept in the cache: {error:#}");
    }
    outcome.cached = cached;
    outcome.wall_s = start.elapsed().as_secs_f64();
    Ok((mesh, outcome))
}

/// Makes a mesh that passes [`verify`]: where one try fails, the next has a smaller envelope and
/// another seed, the last one shorter edges, too.
fn make(
    mesher: &dyn TetMesher,
    package: &Package,
    surface: &SurfaceMesh,
    request: &Request,
    name: &str,
) -> Result<(TetMesh, Outcome)> {
    let mut options = request.options.clone();
    let mut refused = Vec::new();
    for attempt in 1.. {
        let Request { layers, timeout, .. } = request;
        let mut mesh = mesher.mesh(package, surface, layers, &options, *timeout)?;
        finish(&mut mesh, surface, request, options.envelope);
        let error = match verify(&mesh, surface, request, name.to_owned()) {
            Ok(outcome) => return Ok((mesh, Outcome { refused, ..outcome })),
            Err(error) if attempt == ATTEMPTS => {
                return Err(error.context(format!("no usable mesh in {ATTEMPTS} tries")));
            }
            Err(error) => format!("{error:#}"),
        };
        options.envelope *= FINER;
        options.seed += 1;
        let last = attempt + 1 == ATTEMPTS;
        options.edge_length *= if last { SHORTER } else { 1.0 };
        let shorter = if last { " and shorter edges" } else { "" };
        let envelope = options.envelope * 1e3;
        log::warn!("{error}; meshing again with an envelope of {envelope:.4} mm{shorter}");
        refused.push(error);
    }
    unreachable!("the last attempt returns")
}

/// What follows the mesher, whichever it was; it moves the boundary within the envelope of the try.
fn finish(mesh: &mut TetMesh, surface: &SurfaceMesh, request: &Request, envelope: f64) {
    tidy(mesh, surface, envelope);
    if request.layers.is_empty() {
        improve_interior(mesh, request.improve_passes);
    } else if let Some(inside) = exact_facets(&request.layers, mesh) {
        improve_around(mesh, &inside, request.improve_passes);
    }
}

/// As [`settle`], with planar faces where `surface` has them.
pub fn tidy(mesh: &mut TetMesh, surface: &SurfaceMesh, envelope: f64) {
    settle(mesh, envelope);
    let flattened = flatten(mesh, surface, envelope);
    log::debug!("{} vertices moved onto planar faces and their rims", flattened.moved);
    if flattened.left > 0 {
        let (left, envelope) = (flattened.left, 1e3 * envelope);
        log::info!(
            "{left} vertices of flat faces are not exactly in their planes, but within the envelope of {envelope:.3} mm: \
             tetrahedra would turn inside out"
        );
    }
}

/// Positive tetrahedra without fragments, spikes and places where the boundary touches itself.
pub fn settle(mesh: &mut TetMesh, envelope: f64) {
    make_positive(mesh);
    let pinches = open_pinches(mesh);
    if pinches > 0 {
        log::info!("removed {pinches} tets at which the boundary touched itself");
    }
    let fragments = remove_fragments(mesh);
    if fragments > 0 {
        log::info!(
            "removed {fragments} tets that were connected to the body by an edge or a vertex only"
        );
    }
    let spikes = remove_spikes(mesh, envelope);
    if spikes > 0 {
        log::info!(
            "removed {spikes} tets that stood out of the boundary by less than the envelope"
        );
    }
}

fn is_none(count: &usize) -> bool {
    *count == 0
}

fn make_positive(mesh: &mut TetMesh) {
    for tet in &mut mesh.tets {
        let [a, b, c, d] = tet.map(|v| mesh.vertices[v]);
        if tet_volume(a, b, c, d) < 0.0 {
            tet.swap(2, 3);
        }
    }
}

fn verify(
    mesh: &TetMesh,
    surface: &SurfaceMesh,
    request: &Request,
    mesher: String,
) -> Result<Outcome> {
    let mut found = check_tets(mesh);
    if found.is_empty() {
        found.extend(coincident(mesh));
    }
    require(found.is_empty(), || format!("the mesh is not usable:{}", findings(&found)))?;
    let (skin, _) = boundary(mesh).surface(mesh);
    let found = check_surface(&skin);
    require(found.is_empty(), || {
        format!("the boundary of the mesh is not usable:{}", findings(&found))
    })?;
    let shells = components(&skin.triangles).len();
    let wanted = components(&surface.triangles).len();
    require(shells == wanted, || {
        format!("the boundary of the mesh has {shells} shells, the input has {wanted}")
    })?;
    let (volume, input_volume) = (volume(mesh), enclosed_volume(surface));
    let tolerance = area(surface) * request.options.envelope;
    require((volume - input_volume).abs() < tolerance, || {
        format!(
            "the tetrahedra fill {volume:.6e} m3, the surface encloses {input_volume:.6e} m3: more \
             than area × envelope = {tolerance:.1e} m3 apart"
        )
    })?;
    let envelope = request.options.envelope;
    let to_input = distance(&skin, surface, envelope, "the boundary of the mesh", "the input")?;
    let from_input = distance(surface, &skin, envelope, "the input", "the boundary of the mesh")?;
    require_walls(&skin, surface, envelope)?;
    let inside = request.layers.beside(surface).1;
    Ok(Outcome {
        mesher,
        options: request.options.clone(),
        improve_passes: request.improve_passes,
        triangles_inside: inside,
        cached: false,
        refused: Vec::new(),
        vertices: mesh.vertices.len(),
        tets: mesh.tets.len(),
        boundary_facets: skin.triangles.len(),
        shells,
        volume,
        input_volume,
        volume_tolerance: tolerance,
        hausdorff_to_input: to_input,
        hausdorff_from_input: from_input,
        quality: quality(mesh),
        wall_s: 0.0,
    })
}

/// The largest distance of one surface from another [envelope], which is at most 1.
fn distance(
    from: &SurfaceMesh,
    to: &SurfaceMesh,
    envelope: f64,
    name: &str,
    other: &str,
) -> Result<f64, Unusable> {
    let Some((distance, at)) = farthest(from, to, SAMPLES) else { return Ok(0.0) };
    require(distance <= envelope, || {
        format!(
            "{name} is up to {:.4} mm from {other}, at {}: {:.2} of the envelope of {:.4} mm",
            distance * 1e3,
            place(&at),
            distance / envelope,
            envelope * 1e3
        )
    })?;
    Ok(distance / envelope)
}

/// No wall of the mesh is thinner than that of the input beside it by more than the envelope.
fn require_walls(skin: &SurfaceMesh, input: &SurfaceMesh, envelope: f64) -> Result<(), Unusable> {
    let found = thinner(skin, input, envelope);
    let message = |(thickness, wanted, at): (f64, f64, Vec3)| {
        let (thickness, wanted) = (thickness * 1e3, wanted * 1e3);
        format!(
            "a wall of the mesh has {thickness:.4} mm at {}, where the input has {wanted:.4} mm",
            place(&at)
        )
    };
    found.map_or(Ok(()), |found| Err(Unusable(message(found))))
}

/// A place in millimetres.
fn place(p: &Vec3) -> String {
    format!("({:.3}, {:.3}, {:.3}) mm", p.x * 1e3, p.y * 1e3, p.z * 1e3)
}

fn require(holds: bool, message: impl FnOnce() -> String) -> Result<(), Unusable> {
    if holds { Ok(()) } else { Err(Unusable(message())) }
}

impl Outcome {
    /// Logs counts, quality and distances.
    pub fn log(&self) {
        let origin = if self.cached { ", from the cache" } else { "" };
        log::info!(
            "{} tets, {} vertices, {} boundary facets in {} shell(s), by {}, {:.1} s{origin}",
            self.tets,
            self.vertices,
            self.boundary_facets,
            self.shells,
            self.mesher,
            self.wall_s
        );
        log::info!(
            "volume {:.4} cm3, that of the surface {:.4} cm3: {:+.3} %",
            self.volume * 1e6,
            self.input_volume * 1e6,
            100.0 * (self.volume / self.input_volume - 1.0)
        );
        log::info!("{}", self.quality);
        log::info!(
            "distance boundary to input {:.2}, input to boundary {:.2} of the envelope {:.3} mm",
            self.hausdorff_to_input,
            self.hausdorff_from_input,
            self.options.envelope * 1e3
        );
    }
}

#[cfg(test)]
mod tests;
