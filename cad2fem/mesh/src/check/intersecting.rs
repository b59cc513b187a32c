//! Triangles meet nowhere but in the vertices and edges they share.

use super::{Finding, at};
use crate::SurfaceMesh;
use crate::crossings::{self_intersecting_pairs, some_self_intersecting_pairs};

pub const NAME: &str = "intersecting";

/// Pairs after which counting ends.
const MOST_PAIRS: usize = 1_000_000;

/// Pairs of triangles that meet in more than the vertices and edge they share,
/// decided exactly; sorted.
pub fn self_intersections(surface: &SurfaceMesh) -> Vec<(usize, usize)> {
    self_intersecting_pairs(surface)
}

pub fn find(surface: &SurfaceMesh) -> Vec<Finding> {
    let pairs = some_self_intersecting_pairs(surface, MOST_PAIRS);
    let Some(&(s, t)) = pairs.first() else { return Vec::new() };
    let (count, place) = (pairs.len(), at(&surface.centroid(s)));
    let at_least = if count >= MOST_PAIRS { "at least " } else { "" };
    let message = format!(
        "{at_least}{count} pairs of triangles intersect, first triangles {s} and {t} at {place}"
    );
    vec![Finding { rule: NAME, message, count }]
}
