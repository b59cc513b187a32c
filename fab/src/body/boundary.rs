//! The outer boundary and the chamber of a tagged body, as closed surfaces.
//!
//! The boundary of the body is split by the chamber's tag. Each rim of the chamber
//! is closed with a planar cap; then
//!
//! filled part = untagged boundary + caps,  core = reversed chamber + caps,
//! body = filled part − cores,
//!
//! and all three share the caps' triangles and the boundary's vertices bit for bit.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, bail, ensure};
use geometry::cap::{self, Cap};
use mesh::check;
use mesh::io::MshFile;
use mesh::measure::{bounds, diagonal, enclosed_volume, farthest, tet_volume};
use mesh::{SurfaceMesh, Tags, TetMesh, Vec3, topology};
use program::Names;

use crate::body::walls::OFF;
use crate::config::Casts;

/// A rim counts as planar if it keeps to its plane within this part of the body's
/// diagonal: twice the envelope that the volume mesher is given by default.
const PLANAR: f64 = 2e-3;

/// Points per surface at which mesh and model are compared, besides vertices.
const SAMPLES: usize = 20_000;

/// Volumes that should be equal may differ by this part, from rounding.
const VOLUME_ROUNDING: f64 = 1e-9;

/// The surfaces a mold is made from, in the design's coordinates.
#[derive(Clone, Debug)]
pub struct Boundary {
    /// Boundary of the body with its chamber filled [m].
    pub filled: SurfaceMesh,
    /// Boundary of the body: what is cast [m].
    pub cast: SurfaceMesh,
    /// Which surface that is.
    pub casts: Casts,
    /// The other one of model and mesh, on which walls are measured, too [m].
    pub beside: Option<SurfaceMesh>,
    /// What is cast without the groove for its thread, if it has one [m].
    pub plain: Option<SurfaceMesh>,
    /// One per connected piece of a chamber, in the order of the chambers' tags.
    pub cores: Vec<CoreBoundary>,
    /// The paths of rising air.
    pub air_paths: AirPaths,
}

/// A chamber as a solid, and where it opens.
#[derive(Clone, Debug)]
pub struct CoreBoundary {
    /// Tag of its wall; empty where it has none.
    pub chamber: String,
    /// The closed boundary, facing outward [m].
    pub surface: SurfaceMesh,
    /// The openings; none if it is closed.
    pub inlets: Vec<Inlet>,
}

/// An opening of the chamber.
#[derive(Clone, Debug)]
pub struct Inlet {
    /// Centre of the circle inscribed in the rim [m].
    pub centre: Vec3,
    /// Radius of that circle [m].
    pub radius: f64,
    /// Largest distance of the rim from that centre [m].
    pub reach: f64,
    /// Unit normal of the rim's plane, out of the body [1].
    pub normal: Vec3,
    /// Largest distance of a rim vertex from that plane [m].
    pub deviation: f64,
    /// Length of the rim [m].
    pub girth: f64,
    /// What closes it, facing out of the body; empty in a collar [m].
    pub cap: SurfaceMesh,
}

/// Points in and on a body, and edges along which air rises in it.
#[derive(Clone, Debug)]
pub struct AirPaths {
    /// The points [m].
    pub points: Vec<Vec3>,
    /// For each, those it is connected with.
    pub neighbours: Vec<Vec<usize>>,
    /// Points on the outer boundary.
    pub outer: BTreeSet<usize>,
}

impl Boundary {
    /// Splits the boundary of a tagged mesh.
    pub fn new(msh: &MshFile, chambers: &Names) -> Result<Self> {
        let mesh = &msh.mesh;
        let facets = topology::boundary(mesh).facets;
        let chamber = chambers_of(mesh, &facets, &msh.tags, chambers)?;
        let outer = facets.iter().zip(&chamber).filter(|(_, chamber)| chamber.is_none());
        let points = mesh.vertices.clone();
        let edges = topology::tet_edges(&mesh.tets);
        let neighbours = topology::vertex_neighbours(points.len(), &edges);
        let outer = outer.flat_map(|(f, _)| *f).collect();
        let air_paths = AirPaths { points, neighbours, outer };
        let boundary = Self::divided(&mesh.vertices, &facets, &chamber, chambers, air_paths)?;
        boundary.check()?;
        boundary.check_volume(mesh)?;
        Ok(boundary)
    }

    /// The body whose boundary has these facets, each with the index of its chamber, if it is a wall of one.
    fn divided(
        vertices: &[Vec3],
        facets: &[[usize; 3]],
        chamber: &[Option<usize>],
        chambers: &Names,
        air_paths: AirPaths,
    ) -> Result<Self> {
        let of = |i: Option<usize>| -> Facets {
            facets.iter().zip(chamber).filter(|(_, of)| **of == i).map(|(f, _)| *f).collect()
        };
        let walls: Vec<(&String, Facets)> =
            chambers.all().iter().enumerate().map(|(i, tag)| (tag, of(Some(i)))).collect();
        let outer = of(None);
        require_apart(vertices, &walls)?;
        require_one_piece(vertices, &outer)?;
        let limit = PLANAR * diagonal(vertices);
        let mut filled = outer;
        let mut cores = Vec::new();
        for (chamber, wall) in walls {
            for piece in topology::components(&wall) {
                let piece: Vec<[usize; 3]> = piece.into_iter().map(|t| wall[t]).collect();
                let (core, caps) = close_core(vertices, &piece, chamber, limit)?;
                filled.extend(caps);
                cores.push(core);
            }
        }
        Ok(Self {
            filled: topology::submesh(vertices, &filled).0,
            cast: topology::submesh(vertices, facets).0,
            casts: Casts::Mesh,
            beside: None,
            plain: None,
            cores,
            air_paths,
        })
    }

    /// Replaces the boundary of the tetrahedra by the surface of a model. For each triangle of the surface `chamber`
    /// has the index of the chamber whose wall it is, if any.
    pub fn on(
        self,
        surface: &SurfaceMesh,
        chamber: &[Option<usize>],
        chambers: &Names,
    ) -> Result<Self> {
        let Self { air_paths, cast, cores, .. } = self;
        let SurfaceMesh { vertices, triangles } = surface;
        let other = Self::divided(vertices, triangles, chamber, chambers, air_paths)?;
        other.check()?;
        require_same_inlets(&cores, &other.cores)?;
        Ok(Self { casts: Casts::Model, beside: Some(cast), ..other })
    }

    /// Whether the body, as modelled, is where its model is.
    pub fn require_near(surface: &SurfaceMesh, model: &SurfaceMesh) -> Result<()> {
        let limit = OFF * diagonal(&model.vertices);
        let ways = [farthest(surface, model, SAMPLES), farthest(model, surface, SAMPLES)];
        let off = ways.into_iter().map(|way| way.unwrap_or((f64::INFINITY, Vec3::zeros())));
        let (off, at) = off.fold((0.0, Vec3::zeros()), |a, b| if b.0 > a.0 { b } else { a });
        ensure!(
            off <= limit,
            "--model: the mesh is up to {:.3} mm from it, at {}, at most {:.3} mm are allowed: name the surface that was \
             meshed, in metres; for a body whose shape was designed since, name the mesh that the design began with, too \
             (--from tagged.msh)",
            off * 1e3,
            place(&at),
            limit * 1e3
        );
        Ok(())
    }

    fn check(&self) -> Result<()> {
        require_valid("boundary of the body", &self.cast)?;
        require_valid("outer boundary with its cap", &self.filled)?;
        self.cores.iter().try_for_each(|core| require_valid("chamber with its cap", &core.surface))
    }

    fn check_volume(&self, mesh: &TetMesh) -> Result<()> {
        let tets: f64 = mesh
            .tets
            .iter()
            .map(|t| t.map(|v| mesh.vertices[v]))
            .map(|[a, b, c, d]| tet_volume(a, b, c, d).abs())
            .sum();
        let boundary = enclosed_volume(&self.cast);
        ensure!(
            (tets - boundary).abs() <= VOLUME_ROUNDING * tets,
            "the tetrahedra have a volume of {:.6} mm³ but their boundary encloses {:.6} mm³: some are inverted or overlap; \
             use a valid design",
            tets * 1e9,
            boundary * 1e9
        );
        Ok(())
    }
}

/// Facets of a boundary.
type Facets = Vec<[usize; 3]>;

/// For each facet of a boundary the index of the chamber whose wall it is.
pub fn chambers_of(
    mesh: &TetMesh,
    boundary: &[[usize; 3]],
    tags: &Tags,
    chambers: &Names,
) -> Result<Vec<Option<usize>>> {
    let mut of = vec![None; boundary.len()];
    for (i, chamber) in chambers.all().iter().enumerate() {
        let id = tags.id(chamber);
        let tagged = id.map(|id| tags.facets_of(id)).unwrap_or_default();
        ensure!(
            !tagged.is_empty(),
            "no facet has the tag {chamber:?}; the mesh has {}; set `chamber` in mold.toml to the tag of the chamber's wall, \
             to a list of such tags, or to [] if there is no chamber",
            known_tags(tags)
        );
        let wall: Vec<usize> =
            (0..boundary.len()).filter(|&f| tags.get(boundary[f]) == id).collect();
        if wall.len() < tagged.len() {
            let keys = wall.iter().map(|&f| mesh::facet_key(boundary[f]));
            let on_boundary: BTreeSet<[usize; 3]> = keys.collect();
            let first = tagged.iter().find(|f| !on_boundary.contains(*f)).unwrap_or(&tagged[0]);
            bail!(
                "{} facets tagged {chamber:?} are not on the boundary of the tetrahedra, the first at {}; tag the mesh again",
                tagged.len() - wall.len(),
                place(&(first.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 3.0))
            );
        }
        wall.into_iter().for_each(|f| of[f] = Some(i));
    }
    Ok(of)
}

/// A surface has the inlets of another one.
fn require_same_inlets(mesh: &[CoreBoundary], model: &[CoreBoundary]) -> Result<()> {
    let inlets = |cores: &[CoreBoundary]| cores.iter().map(|core| core.inlets.len()).sum::<usize>();
    let [on_mesh, on_model] = [mesh, model].map(|cores| [cores.len(), inlets(cores)]);
    ensure!(
        on_mesh == on_model,
        "--model: it has {} chambers with {} inlets where the tetrahedra have {} with {}: tag the chamber by regions of the \
         model, or cast the boundary of the tetrahedra (surface = \"mesh\" in mold.toml)",
        on_model[0],
        on_model[1],
        on_mesh[0],
        on_mesh[1]
    );
    Ok(())
}

/// Walls of different chambers have no vertex in common.
fn require_apart(vertices: &[Vec3], walls: &[(&String, Facets)]) -> Result<()> {
    let mut owner = BTreeMap::new();
    for (chamber, wall) in walls {
        for &v in wall.iter().flatten() {
            let first: &&String = owner.entry(v).or_insert(*chamber);
            ensure!(
                *first == *chamber,
                "the chambers {first:?} and {chamber:?} touch at {}: two cores cannot be held apart there; leave a wall \
                 between them, or give both walls one tag",
                place(&vertices[v])
            );
        }
    }
    Ok(())
}

fn known_tags(tags: &Tags) -> String {
    if tags.names.is_empty() {
        return "no tags at all".into();
    }
    let count = |id: usize| tags.facets.values().filter(|&&i| i as usize == id).count();
    let list: Vec<String> = tags
        .names
        .iter()
        .enumerate()
        .map(|(i, name)| format!("{name} ({} facets)", count(i + 1)))
        .collect();
    list.join(", ")
}

/// A chamber wall as a core, and the caps at its rims.
fn close_core(
    vertices: &[Vec3],
    wall: &[[usize; 3]],
    chamber: &str,
    limit: f64,
) -> Result<(CoreBoundary, Facets)> {
    let rims = topology::boundary_loops(wall);
    let mut caps = Vec::new();
    let mut inlets = Vec::new();
    for rim in rims {
        let polygon: Vec<Vec3> = rim.iter().map(|&v| vertices[v]).collect();
        let at = || place(&(polygon.iter().sum::<Vec3>() / polygon.len() as f64));
        let Cap { triangles, normal, deviation } = cap::close(&polygon)
            .with_context(|| format!("the rim of the chamber around {}", at()))?;
        ensure!(
            deviation <= limit,
            "the rim of the chamber around {} leaves its plane by {:.3} mm, at most {:.3} mm are allowed: cut the inlet flat, \
             or mesh it with a smaller envelope if it is flat in the model",
            at(),
            deviation * 1e3,
            limit * 1e3
        );
        let (centre, radius) = cap::inscribed_circle(&polygon, &normal);
        let next = polygon.iter().cycle().skip(1);
        let girth = polygon.iter().zip(next).map(|(p, q)| (q - p).norm()).sum();
        let reach = polygon.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let closed: Facets = triangles.into_iter().map(|t| t.map(|i| rim[i])).collect();
        let cap = topology::submesh(vertices, &closed).0;
        inlets.push(Inlet { centre, radius, reach, normal, deviation, girth, cap });
        caps.extend(closed);
    }
    let reversed = wall.iter().map(|&[a, b, c]| [a, c, b]);
    let facets: Facets = reversed.chain(caps.iter().copied()).collect();
    let surface = topology::submesh(vertices, &facets).0;
    Ok((CoreBoundary { chamber: chamber.into(), surface, inlets }, caps))
}

/// The outer boundary must be connected: a second piece is another body or a closed chamber.
fn require_one_piece(vertices: &[Vec3], outer: &[[usize; 3]]) -> Result<()> {
    let pieces = topology::components(outer);
    let Some(second) = pieces.get(1) else { return Ok(()) };
    let facets: Facets = second.iter().map(|&t| outer[t]).collect();
    let surface = topology::submesh(vertices, &facets).0;
    let (low, high) = bounds(&surface.vertices);
    bail!(
        "the boundary without the chamber's tag has {} separate pieces, one is needed; the second, of {} facets, encloses \
         {:.1} mm³ around {}: tag closed chambers, mold bodies one by one; if a few facets of the chamber have no tag, raise \
         the tagger's epsilon",
        pieces.len(),
        second.len(),
        enclosed_volume(&surface) * 1e9,
        place(&((low + high) / 2.0))
    );
}

fn require_valid(what: &str, surface: &SurfaceMesh) -> Result<()> {
    let findings = check::check_surface(surface);
    let messages: Vec<String> = findings.into_iter().map(|f| f.message).collect();
    ensure!(
        messages.is_empty(),
        "the {what} is not a valid closed surface: {}",
        messages.join("; ")
    );
    Ok(())
}

/// A point in words.
fn place(p: &Vec3) -> String {
    format!("({:.5}, {:.5}, {:.5}) m", p.x, p.y, p.z)
}
