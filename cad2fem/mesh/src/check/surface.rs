//! Rules for surfaces.

use super::{Finding, at, lost, not_finite};
use crate::crossings::some_self_intersecting_pairs;
use crate::measure::{enclosed_volume, is_flat};
use crate::topology::{
    boundary_edges, boundary_loops, directed_edges, edge_facets, pinched_vertices,
};
use crate::{SurfaceMesh, Vec3};

/// Pairs of triangles that intersect after which counting ends.
const MOST_PAIRS: usize = 1_000_000;

/// There are triangles, their indices exist and coordinates are finite.
pub fn finite(surface: &SurfaceMesh) -> Vec<Finding> {
    let n = surface.vertices.len();
    let empty = || format!("the surface is empty: {n} vertices, no triangles");
    let empty = surface.triangles.is_empty().then(|| Finding::new("finite", 1, empty()));
    let infinite = not_finite(&surface.vertices, "surface");
    let lost = lost("finite", &surface.triangles, n, ["triangles", "triangle"]);
    [empty, infinite, lost].into_iter().flatten().collect()
}

/// Every triangle has three different corners and an area.
pub fn degenerate(surface: &SurfaceMesh) -> Vec<Finding> {
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
    vec![Finding::new("degenerate", count, message)]
}

/// Every edge has a triangle on both sides.
pub fn closed(surface: &SurfaceMesh) -> Vec<Finding> {
    let edges = boundary_edges(&surface.triangles);
    let Some(&[a, b]) = edges.first() else { return Vec::new() };
    let count = edges.len();
    let length: f64 =
        edges.iter().map(|&[a, b]| (surface.vertices[b] - surface.vertices[a]).norm()).sum();
    let rims = boundary_loops(&surface.triangles).len();
    let message = format!(
        "{count} edges in {rims} rims have a single triangle, {length:.6} m in total, first edge \
         {a}-{b} at {}",
        at(&middle(surface, [a, b]))
    );
    vec![Finding::new("closed", count, message)]
}

/// At most two triangles at every edge, one fan of triangles at every vertex.
pub fn manifold(surface: &SurfaceMesh) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut crowded = edge_facets(&surface.triangles);
    crowded.retain(|_, facets| facets.len() > 2);
    if let Some((&edge, facets)) = crowded.first_key_value() {
        let ([a, b], place) = (edge, at(&middle(surface, edge)));
        let (count, most) = (crowded.len(), facets.len());
        let message = format!(
            "{count} edges have more than two triangles, first edge {a}-{b} with {most} at {place}"
        );
        findings.push(Finding::new("manifold", count, message));
    }
    let pinched = pinched_vertices(&surface.triangles);
    if let Some(&v) = pinched.first() {
        let (count, place) = (pinched.len(), at(&surface.vertices[v]));
        let message =
            format!("at {count} vertices sheets touch in a point, first vertex {v} at {place}");
        findings.push(Finding::new("manifold", count, message));
    }
    findings
}

/// Neighbours wind alike, and closed surfaces face outward.
pub fn oriented(surface: &SurfaceMesh) -> Vec<Finding> {
    let mut edges: Vec<[usize; 2]> =
        surface.triangles.iter().flat_map(|&t| directed_edges(t)).collect();
    edges.sort_unstable();
    let mut twice: Vec<[usize; 2]> =
        edges.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    twice.dedup();
    if let Some(&[a, b]) = twice.first() {
        let (count, place) = (twice.len(), at(&middle(surface, [a, b])));
        let message = format!(
            "at {count} edges neighbouring triangles wind oppositely, first edge {a}-{b} at {place}"
        );
        return vec![Finding::new("oriented", count, message)];
    }
    let volume = enclosed_volume(surface);
    if volume > 0.0 || !boundary_edges(&surface.triangles).is_empty() {
        return Vec::new();
    }
    let message = format!("the enclosed volume is {volume:.6e} m³: triangles face inward");
    vec![Finding::new("oriented", 1, message)]
}

/// Triangles meet nowhere but in the vertices and edges they share.
pub fn intersecting(surface: &SurfaceMesh) -> Vec<Finding> {
    let pairs = some_self_intersecting_pairs(surface, MOST_PAIRS);
    let Some(&(s, t)) = pairs.first() else { return Vec::new() };
    let (count, place) = (pairs.len(), at(&surface.centroid(s)));
    let at_least = if count >= MOST_PAIRS { "at least " } else { "" };
    let message = format!(
        "{at_least}{count} pairs of triangles intersect, first triangles {s} and {t} at {place}"
    );
    vec![Finding::new("intersecting", count, message)]
}

fn middle(surface: &SurfaceMesh, [a, b]: [usize; 2]) -> Vec3 {
    (surface.vertices[a] + surface.vertices[b]) / 2.0
}
