//! A patch that moves along its normals as a whole: one number, how far.
//!
//! v' = v + θ r(v) d(v)
//!
//! d(v)   move of a vertex per distance, so that the facets at it move by that ([`shifts`]), out of the silicone
//! r(v)   rises from 0 at the rim to 1 within a few edges of it, along the surface [1]

use mechanics::symmetry::OFF_PLANE;
use mesh::measure::mean_edge;
use mesh::offset::shifts;
use mesh::{Vec3, topology};

use super::geodesic::Geodesics;
use super::held::{Held, off};

/// Width of the rise at the rim, in mean edges.
const RISE: f64 = 2.0;

/// The vertices of a patch off its rim at rest positions, ascending, and r d of each.
pub fn moves(
    rest: &[Vec3],
    facets: &[[usize; 3]],
    held: Held,
) -> impl Iterator<Item = (usize, Vec3)> {
    let (surface, ids) = topology::submesh(rest, facets);
    let rim = held.rim(&surface, &ids);
    let width = RISE * mean_edge(&surface.vertices, &surface.triangles);
    let rise = |distance: f64| (distance / width).min(1.0);
    let rises: Vec<f64> = match rim.is_empty() {
        true => vec![1.0; ids.len()],
        false => Geodesics::new(&surface).distances(&rim).into_iter().map(rise).collect(),
    };
    let moves = shifts(rest, facets);
    let off_rim = ids.into_iter().zip(rises).filter(|(_, rise)| *rise > OFF_PLANE);
    off_rim.map(move |(v, rise)| (v, rise * off(&held.directions(v).0, &moves[&v])))
}
