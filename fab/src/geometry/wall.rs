//! The thinnest wall of a body.
//!
//! The thickness at a point of the surface is the length of the straight line through the body to
//! a facet that faces the other way, within [`OPPOSITE`]; where the surface across is
//! tilted more, as near a sharp edge, there is no wall to measure.

use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3, measure};
use rayon::prelude::*;

/// Cosine of the greatest angle between a wall's sides that counts as parallel (60°): beyond
/// it is an edge, whose thickness is zero and no fault.
const OPPOSITE: f64 = 0.5;

/// Thicknesses that differ by less are equal: what files of a hand-sized mold resolve [m].
const ROUNDING: f64 = 1e-8;

/// The thinnest wall and where it begins [m], if it is thinner than `least` [m].
#[must_use]
pub fn too_thin(surface: &SurfaceMesh, least: f64) -> Option<(f64, Vec3)> {
    thinnest(surface).filter(|(thickness, _)| *thickness < least - ROUNDING)
}

/// The thinnest wall and where it begins, in the surface's unit; none if no facets face each
/// other.
#[must_use]
pub fn thinnest(surface: &SurfaceMesh) -> Option<(f64, Vec3)> {
    let bvh = SurfaceBvh::new(surface);
    let normals: Vec<Vec3> = (0..surface.triangles.len())
        .map(|t| {
            let [a, b, c] = surface.corners(t);
            measure::triangle_normal(a, b, c)
        })
        .collect();
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
    use mesh::solid::Solid;

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
