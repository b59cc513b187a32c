//! Better tetrahedra inside an untouched boundary.
//!
//! A mesh whose boundary has moved keeps its connectivity while its elements are
//! squashed or stretched. Here interior vertices move, edges and facets are
//! exchanged, and interior vertices are removed or added, each only where the
//! worst tetrahedron concerned gets better (Freitag, Ollivier-Gooch 1997;
//! Klingner, Shewchuk 2007). Boundary vertices and boundary facets stay as they
//! are, bit for bit.

mod complex;
mod flip;
mod inside;
mod resample;
mod shape;
mod smooth;
mod surface;
#[cfg(test)]
mod tests;

use crate::TetMesh;
use crate::measure::{Quality, quality};
use complex::Complex;
use inside::Inside;
pub use inside::{improve_around, improve_tagged};
use serde::Serialize;
pub use surface::{SurfaceReport, improve_with_surface, usual_tolerance};

/// Tetrahedra below this shape have their edges and facets exchanged; the shape of
/// a regular one is 1.
const FLIP_BELOW: f64 = 0.5;

/// Near tetrahedra below this shape vertices are removed or added.
const RESAMPLE_BELOW: f64 = 0.2;

/// Vertices are removed and added in every third sweep only: moves and exchanges,
/// which keep their number, come first.
const RESAMPLE_EVERY: usize = 3;

/// Sweeps over the vertices of inverted tetrahedra, before anything else.
const UNTANGLE_SWEEPS: usize = 10;

/// What an improvement did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImproveReport {
    /// Quality before.
    pub before: Quality,
    /// Quality after.
    pub after: Quality,
    /// Moves of interior vertices.
    pub moved: usize,
    /// Exchanges of edges and facets.
    pub flips: usize,
    /// Interior vertices removed.
    pub removed: usize,
    /// Interior vertices added.
    pub added: usize,
}

/// Improves the tetrahedra of a mesh inside its boundary, in at most `passes`
/// sweeps (10 are plenty); it stops when a sweep changes nothing.
///
/// Boundary vertices keep their numbers, so that facet tags stay valid; interior
/// ones may be renumbered. Interior vertices are only removed as long as no
/// boundary vertex has a number beyond their count: a mesh that numbers its
/// boundary first leaves most freedom. Inverted tetrahedra are repaired where
/// possible; `after.radius_ratio_min` is positive if all were.
///
/// The result depends on nothing but the arguments.
pub fn improve_interior(mesh: &mut TetMesh, passes: usize) -> ImproveReport {
    improve(mesh, &mut Inside::nothing(mesh), passes)
}

/// [`improve_interior`] around what stays inside. Tetrahedra are put in the order of their volumes.
fn improve(mesh: &mut TetMesh, inside: &mut Inside, passes: usize) -> ImproveReport {
    let before = quality(mesh);
    let mut complex = Complex::new(mesh, inside);
    let (mut moved, mut flips, mut removed, mut added) = (0, 0, 0, 0);
    for _ in 0..UNTANGLE_SWEEPS {
        moved += smooth::untangle(&mut complex);
    }
    let mut since = 0;
    for pass in 1..=passes {
        let start = complex.now();
        flips += flip::flip(&mut complex, FLIP_BELOW, since);
        moved += smooth::smooth(&mut complex, since);
        if pass % RESAMPLE_EVERY == 0 {
            removed += resample::contract(&mut complex, RESAMPLE_BELOW);
            added += resample::insert(&mut complex, RESAMPLE_BELOW);
        }
        if complex.now() == start && pass >= RESAMPLE_EVERY {
            break;
        }
        since = start + 1;
    }
    (*mesh, inside.volumes) = complex.into_mesh();
    ImproveReport { before, after: quality(mesh), moved, flips, removed, added }
}
