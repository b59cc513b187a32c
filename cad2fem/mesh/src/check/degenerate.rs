//! Every triangle has three different corners and an area.

use super::{Finding, at};
use crate::SurfaceMesh;
use crate::measure::triangle_area;

pub const NAME: &str = "degenerate";

/// A triangle whose height is below this fraction of its longest edge is flat:
/// its normal is lost to rounding in 64 bits times a margin of 10⁴.
const FLAT: f64 = 1e-12;

pub fn find(surface: &SurfaceMesh) -> Vec<Finding> {
    let flat = |t: &usize| {
        let [a, b, c] = surface.corners(*t);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        2.0 * triangle_area(a, b, c) <= FLAT * longest * longest
    };
    let flat: Vec<usize> = (0..surface.triangles.len()).filter(flat).collect();
    let Some(&first) = flat.first() else { return Vec::new() };
    let (count, total) = (flat.len(), surface.triangles.len());
    let place = at(&surface.centroid(first));
    let message =
        format!("{count} of {total} triangles have no area, first triangle {first} at {place}");
    vec![Finding { rule: NAME, message, count }]
}
