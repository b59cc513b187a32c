//! Neighbours wind alike, and closed surfaces face outward.

use super::{Finding, at};
use crate::SurfaceMesh;
use crate::measure::enclosed_volume;
use crate::topology::{boundary_edges, directed_edges};

pub const NAME: &str = "oriented";

pub fn find(surface: &SurfaceMesh) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut add = |count, message| findings.push(Finding { rule: NAME, message, count });
    let mut edges: Vec<[usize; 2]> =
        surface.triangles.iter().flat_map(|&t| directed_edges(t)).collect();
    edges.sort_unstable();
    let mut twice: Vec<[usize; 2]> =
        edges.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    twice.dedup();
    if let Some(&[a, b]) = twice.first() {
        let place = at(&((surface.vertices[a] + surface.vertices[b]) / 2.0));
        let count = twice.len();
        let message = format!(
            "at {count} edges neighbouring triangles wind oppositely, first edge {a}-{b} at {place}"
        );
        add(count, message);
    } else if boundary_edges(&surface.triangles).is_empty() {
        let volume = enclosed_volume(surface);
        if volume <= 0.0 {
            add(1, format!("the enclosed volume is {volume:.6e} m³: triangles face inward"));
        }
    }
    findings
}
