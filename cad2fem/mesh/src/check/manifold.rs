//! At most two triangles at every edge, one fan of triangles at every vertex.

use super::{Finding, at};
use crate::SurfaceMesh;
use crate::topology::{edge_facets, pinched_vertices};

pub const NAME: &str = "manifold";

pub fn find(surface: &SurfaceMesh) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut add = |count, message| findings.push(Finding { rule: NAME, message, count });
    let crowded: Vec<_> = edge_facets(&surface.triangles)
        .into_iter()
        .filter(|(_, facets)| facets.len() > 2)
        .collect();
    if let Some(([a, b], facets)) = crowded.first() {
        let place = at(&((surface.vertices[*a] + surface.vertices[*b]) / 2.0));
        let (count, most) = (crowded.len(), facets.len());
        let message = format!(
            "{count} edges have more than two triangles, first edge {a}-{b} with {most} at {place}"
        );
        add(count, message);
    }
    let pinched = pinched_vertices(&surface.triangles);
    if let Some(&v) = pinched.first() {
        let (count, place) = (pinched.len(), at(&surface.vertices[v]));
        let message =
            format!("at {count} vertices sheets touch in a point, first vertex {v} at {place}");
        add(count, message);
    }
    findings
}
