//! What of a patch may not move, or only along a plane.

use anyhow::{Result, ensure};
use mesh::measure::mean_edge;
use mesh::{SurfaceMesh, Vec3};

use super::Geodesics;
use super::sampling::open_rim;
use crate::config::KeepConfig;
use crate::symmetry::{AXES, FLAT, Plane};

/// A flat face that stays in its plane across an axis.
#[derive(Clone, Debug)]
pub struct Flat {
    axis: usize,
    /// Vertices in the plane, ascending.
    vertices: Vec<usize>,
}

impl Flat {
    /// The vertices of the facets that move in a plane.
    ///
    /// # Errors
    /// With the nearest vertex when no facet lies in the plane.
    pub fn find(keep: &KeepConfig, rest: &[Vec3], moving: &[[usize; 3]]) -> Result<Self> {
        let axis = keep.axis as usize;
        let off = |v: usize| (rest[v][axis] - keep.at).abs();
        let tolerance = FLAT * mean_edge(rest, moving);
        let within = |facet: &&[usize; 3]| facet.iter().all(|&v| off(v) <= tolerance);
        let nearest = moving.iter().flatten().map(|&v| off(v)).fold(f64::INFINITY, f64::min);
        ensure!(
            moving.iter().any(|facet| within(&facet)),
            "[shape] keep: no facet that moves lies in the plane {} = {} m; the nearest vertex is {:.3} mm \
             off it",
            AXES[axis],
            keep.at,
            1e3 * nearest
        );
        let mut vertices: Vec<usize> =
            moving.iter().flatten().copied().filter(|&v| off(v) <= tolerance).collect();
        vertices.sort_unstable();
        vertices.dedup();
        Ok(Self { axis, vertices })
    }
}

/// What holds the vertices of a patch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held<'a> {
    /// Planes of symmetry that may cut it: what lies in one moves along it.
    pub planes: &'a [Plane],
    /// Flat faces.
    pub flats: &'a [Flat],
    /// Nothing nearer to the rim than this, along the surface, moves [m].
    pub margin: f64,
}

impl Held<'_> {
    /// Whether a vertex of the body does not move along axis `k`.
    #[must_use]
    pub fn along(&self, vertex: usize, k: usize) -> bool {
        let flat = |f: &Flat| f.axis == k && f.vertices.binary_search(&vertex).is_ok();
        self.planes.iter().any(|plane| plane.axis == k && plane.contains(vertex))
            || self.flats.iter().any(flat)
    }

    /// The vertices of a patch that do not move at all, ascending; `ids` are its vertices in the
    /// body.
    #[must_use]
    pub fn rim(&self, surface: &SurfaceMesh, ids: &[usize]) -> Vec<usize> {
        let rim = open_rim(surface, ids, self.planes);
        if self.margin == 0.0 || rim.is_empty() {
            return rim;
        }
        let distances = Geodesics::new(surface).within(&rim, self.margin);
        (0..ids.len()).filter(|&v| distances[v] < self.margin).collect()
    }
}
