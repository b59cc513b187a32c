//! Every edge has a triangle on both sides.

use super::{Finding, at};
use crate::SurfaceMesh;
use crate::topology::{boundary_edges, boundary_loops};

pub const NAME: &str = "closed";

pub fn find(surface: &SurfaceMesh) -> Vec<Finding> {
    let edges = boundary_edges(&surface.triangles);
    let Some(&[a, b]) = edges.first() else { return Vec::new() };
    let count = edges.len();
    let length: f64 =
        edges.iter().map(|&[a, b]| (surface.vertices[b] - surface.vertices[a]).norm()).sum();
    let rims = boundary_loops(&surface.triangles).len();
    let place = at(&((surface.vertices[a] + surface.vertices[b]) / 2.0));
    let message = format!(
        "{count} edges in {rims} rims have a single triangle, {length:.6} m in total, first edge \
         {a}-{b} at {place}"
    );
    vec![Finding { rule: NAME, message, count }]
}
