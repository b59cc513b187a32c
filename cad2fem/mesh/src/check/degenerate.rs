//! Every triangle has three different corners and an area.

use super::{Finding, at};
use crate::SurfaceMesh;
use crate::measure::is_flat;

pub const NAME: &str = "degenerate";

pub fn find(surface: &SurfaceMesh) -> Vec<Finding> {
    let flat = |t: &usize| {
        let [a, b, c] = surface.corners(*t);
        is_flat(a, b, c)
    };
    let flat: Vec<usize> = (0..surface.triangles.len()).filter(flat).collect();
    let Some(&first) = flat.first() else { return Vec::new() };
    let (count, total) = (flat.len(), surface.triangles.len());
    let place = at(&surface.centroid(first));
    let message =
        format!("{count} of {total} triangles have no area, first triangle {first} at {place}");
    vec![Finding { rule: NAME, message, count }]
}
