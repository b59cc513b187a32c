//! Better tetrahedra where the boundary itself has to change.
//!
//! A tetrahedron with four vertices on the boundary, or one on a stretched facet, can stay flat
//! whatever the interior does. Here edges of the boundary are exchanged, contracted and split and
//! its vertices slide, near such tetrahedra only and only where the worst of those concerned gets
//! better. Only facets that may move change: the rims of their tags, and all other facets, stay as
//! they are. No point of the old surface is farther from the new one than a tolerance, nor the
//! other way round, so that sharp edges stay where they are.

mod skin;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use self::skin::{Facet, Old, Skin};
use super::inside::{Inside, improve_tagged};
use super::{ImproveReport, improve};
use crate::crossings::self_intersecting_pairs;
use crate::measure::{hausdorff, mean_edge, quality};
use crate::topology::{boundary, is_manifold, pinched_vertices, submesh};
use crate::{SurfaceMesh, Tags, TetMesh, Vec3, facet_key};

/// Tetrahedra below this shape, at the surface that moves, make it change. A regular one has 1,
/// the worst of fTetWild about as much as this.
const POOR: f64 = 0.02;
/// Changes of the boundary, each followed by an improvement of the interior.
const ROUNDS: usize = 3;
/// How far a surface may move unless somebody says, in its mean edges [1].
const TOLERANCE: f64 = 0.05;
/// Points at which distances are measured.
const SAMPLES: usize = 20_000;

/// What a re-meshing of the surface did.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SurfaceReport {
    /// Edges of the boundary exchanged, those of tetrahedra that were taken off among them.
    pub flips: usize,
    /// Edges of the boundary contracted.
    pub collapses: usize,
    /// Edges of the boundary split.
    pub splits: usize,
    /// Moves of boundary vertices.
    pub moved: usize,
    /// Largest distance between the old surface that moves and the new one, at samples [m].
    pub distance: f64,
}

impl SurfaceReport {
    /// Whether anything changed.
    pub fn changed(&self) -> bool {
        self.flips + self.collapses + self.splits + self.moved > 0
    }
}

/// How far facets may move when they are re-meshed, unless somebody says: a twentieth of their mean
/// edge [m].
pub fn usual_tolerance(vertices: &[Vec3], moving: &[[usize; 3]]) -> f64 {
    TOLERANCE * mean_edge(vertices, moving)
}

/// Improves a mesh, with at most `passes` sweeps over its interior after each change of its
/// boundary. The boundary facets `moving` may change within `tolerance` [m] of where they are.
/// Vertices get new numbers; tags follow them. Facets inside with a tag, and those where volumes
/// meet, stay where they are with all their vertices, those at the boundary among them; so do the
/// volumes but for what the boundary changes.
///
/// Where the new boundary would not be valid, or would be farther away, it stays as it is and the
/// interior alone is improved.
pub fn improve_with_surface(
    mesh: &mut TetMesh,
    tags: &mut Tags,
    moving: &[[usize; 3]],
    tolerance: f64,
    passes: usize,
) -> (ImproveReport, SurfaceReport) {
    let before = quality(mesh);
    let old = Old::new(submesh(&mesh.vertices, moving).0, tolerance);
    let (mut new, mut facets) = (mesh.clone(), label(mesh, tags, moving));
    let mut inside = Inside::tagged(mesh, tags);
    let mut report = SurfaceReport::default();
    let mut interior = improve(&mut new, &mut inside, passes);
    for _ in 0..ROUNDS {
        let mut skin = Skin::new(&new, &inside, facets, &old);
        let changed = sweep(&mut skin, &mut report);
        (new, inside, facets) = skin.into_mesh();
        if !changed {
            break;
        }
        let more = improve(&mut new, &mut inside, passes);
        interior.moved += more.moved;
        interior.flips += more.flips;
        interior.removed += more.removed;
        interior.added += more.added;
    }
    if report.changed() {
        report.distance = distance(&old.surface, &new, &facets);
        if report.distance > tolerance || !is_valid(&new, &facets) {
            return (improve_tagged(mesh, tags, passes), SurfaceReport::default());
        }
    }
    *mesh = new;
    let tagged = |(key, facet): (&[usize; 3], &Facet)| Some((*key, facet.tag?));
    let tags_inside = inside.facets.iter().filter_map(|(key, tag)| Some((*key, (*tag)?)));
    tags.facets = facets.iter().filter_map(tagged).chain(tags_inside).collect();
    if !tags.volumes.names.is_empty() {
        tags.volumes.of = inside.volumes;
    }
    interior.before = before;
    interior.after = quality(mesh);
    (interior, report)
}

/// The boundary facets of a mesh with their tags.
fn label(mesh: &TetMesh, tags: &Tags, moving: &[[usize; 3]]) -> BTreeMap<[usize; 3], Facet> {
    let moving: BTreeSet<[usize; 3]> = moving.iter().map(|&facet| facet_key(facet)).collect();
    let facet = |corners: [usize; 3]| {
        let key = facet_key(corners);
        (key, Facet { corners, tag: tags.get(corners), moves: moving.contains(&key) })
    };
    boundary(mesh).facets.into_iter().map(facet).collect()
}

/// One pass over the poor tetrahedra, worst first; whether anything changed.
fn sweep(skin: &mut Skin, report: &mut SurfaceReport) -> bool {
    let before = report.clone();
    for t in skin.complex.worse_than(POOR) {
        let Some(tet) = skin.complex.tet(t) else { continue };
        // a tetrahedron may have taken the number of one that has been replaced
        if skin.complex.shape(t) >= POOR {
            continue;
        }
        let mut edges = skin.free_edges(tet);
        if edges.iter().any(|&edge| skin.flip(edge)) {
            report.flips += 1;
        } else if edges.iter().any(|&[a, b]| skin.collapse(a, b) || skin.collapse(b, a)) {
            report.collapses += 1;
        } else if tet.iter().any(|&v| skin.slide(v)) {
            report.moved += 1;
        } else {
            edges.sort_by(|&e, &f| skin.length(f).total_cmp(&skin.length(e)));
            report.splits += usize::from(edges.iter().any(|&edge| skin.split(edge)));
        }
    }
    *report != before
}

/// Largest distance between the old surface and the facets that move now [m].
fn distance(old: &SurfaceMesh, mesh: &TetMesh, facets: &BTreeMap<[usize; 3], Facet>) -> f64 {
    let moving: Vec<[usize; 3]> = facets.values().filter(|f| f.moves).map(|f| f.corners).collect();
    let (new, _) = submesh(&mesh.vertices, &moving);
    hausdorff(old, &new, SAMPLES).max(hausdorff(&new, old, SAMPLES))
}

/// Whether the facets are the boundary of the mesh, and this neither touches nor crosses itself.
fn is_valid(mesh: &TetMesh, facets: &BTreeMap<[usize; 3], Facet>) -> bool {
    let skin = boundary(mesh).facets;
    let same =
        skin.len() == facets.len() && skin.iter().all(|f| facets.contains_key(&facet_key(*f)));
    let surface = SurfaceMesh { vertices: mesh.vertices.clone(), triangles: skin };
    same && is_manifold(&surface.triangles)
        && pinched_vertices(&surface.triangles).is_empty()
        && self_intersecting_pairs(&surface).is_empty()
}
