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

/// The moves of the vertices of a patch per distance.
#[derive(Clone, Debug)]
pub struct Swelling {
    /// Vertex ids off the rim, ascending.
    pub vertices: Vec<usize>,
    /// r d of each.
    pub ways: Vec<Vec3>,
}

impl Swelling {
    /// Makes the map of a patch at rest positions.
    pub fn new(rest: &[Vec3], facets: &[[usize; 3]], held: Held) -> Self {
        let (surface, ids) = topology::submesh(rest, facets);
        let rim = held.rim(&surface, &ids);
        let width = RISE * mean_edge(&surface.vertices, &surface.triangles);
        let rise = |distance: f64| (distance / width).min(1.0);
        let rises: Vec<f64> = match rim.is_empty() {
            true => vec![1.0; ids.len()],
            false => Geodesics::new(&surface).distances(&rim).into_iter().map(rise).collect(),
        };
        let moves = shifts(rest, facets);
        let (mut vertices, mut ways) = (Vec::new(), Vec::new());
        for (&v, rise) in ids.iter().zip(rises) {
            if rise > OFF_PLANE {
                vertices.push(v);
                ways.push(rise * off(&held.directions(v).0, &moves[&v]));
            }
        }
        Self { vertices, ways }
    }

    /// Positions of its vertices [m].
    pub fn apply(&self, distance: f64, rest: &[Vec3]) -> Vec<Vec3> {
        self.vertices.iter().zip(&self.ways).map(|(&v, way)| rest[v] + distance * way).collect()
    }

    /// Cotangent of the distance.
    pub fn vjp(&self, bar: &[Vec3]) -> f64 {
        self.ways.iter().zip(bar).map(|(way, bar)| way.dot(bar)).sum()
    }
}
