//! Walls of a body: how thin they are, and where.
//!
//! The thickness of a wall at a point of its surface is the length of the straight line through it
//! to a facet that faces the other way, within 60°; where the surface across is tilted
//! more, as near a sharp edge, there is no wall to measure.

use rayon::prelude::*;

use crate::bvh::SurfaceBvh;
use crate::measure::triangle_normal;
use crate::{SurfaceMesh, Vec3};

/// Cosine of the greatest angle between a wall's sides that counts as parallel (60°): beyond
/// it is an edge, whose thickness is zero and no fault.
const OPPOSITE: f64 = 0.5;

/// The thinnest wall of a closed surface and where it begins, in the unit of the surface, measured
/// through the centroid of every triangle; `None` if no two triangles are opposite to each other.
#[must_use]
pub fn thinnest(surface: &SurfaceMesh) -> Option<(f64, Vec3)> {
    let normal = |t: usize| {
        let [a, b, c] = surface.corners(t);
        triangle_normal(a, b, c)
    };
    let normals: Vec<Vec3> = (0..surface.triangles.len()).map(normal).collect();
    thinnest_along(surface, &normals)
}

/// The same with given outward unit normals of the triangles, for surfaces with needles, whose own
/// normals say little.
#[must_use]
pub fn thinnest_along(surface: &SurfaceMesh, normals: &[Vec3]) -> Option<(f64, Vec3)> {
    let bvh = SurfaceBvh::new(surface);
    let way = |t: usize| {
        let (from, inward) = (surface.centroid(t), -normals[t]);
        let hits = bvh.ray(&from, &inward);
        // The first facet that is not entered again, as its own and its neighbours' are.
        let (s, across) = hits.into_iter().find(|&(_, hit)| normals[hit].dot(&inward) > 0.0)?;
        (normals[across].dot(&inward) >= OPPOSITE).then_some((s, from))
    };
    let ways = (0..surface.triangles.len()).into_par_iter().filter_map(way);
    ways.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::solid::Solid;

    #[test]
    fn a_wall_is_measured_straight_through() {
        // A box with a hole that leaves 1.5 mm at its thinnest side.
        let outer = Solid::cube(&Vec3::zeros(), &Vec3::new(20.0, 20.0, 20.0));
        let hole = Solid::cube(&Vec3::new(5.0, 1.5, 5.0), &Vec3::new(15.0, 15.0, 15.0));
        let (thickness, at) = thinnest(&outer.difference(&hole).to_surface()).unwrap();
        assert!((thickness - 1.5).abs() < 1e-12, "{thickness} at {at}");
        // Near the edge of a wedge there is no wall.
        let wedge = outer.trim_by_plane(&Vec3::new(1.0, 0.0, -1.0).normalize(), 0.0);
        let (thickness, _) = thinnest(&wedge.to_surface()).unwrap();
        assert!(thickness > 1.0, "{thickness}");
    }
}
