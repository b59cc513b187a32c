//! Slivers of a surface, exchanged for better triangles.
//!
//! A corner of a sliver that moves a little less than its longest edge lies on the other side of it, upside down on
//! its neighbour. So the edge between both is exchanged for that between the corners opposite, where the surface does
//! not move by more than a tolerance.

use std::collections::BTreeSet;

use mesh::topology::{directed_edges, edge_facets};
use mesh::{SurfaceMesh, Vec3};

/// Slivers are thinner than this part of their longest edge.
const SLIVER: f64 = 0.2;

/// Times that edges are exchanged, at most: one may have to wait for others.
const ROUNDS: usize = 30;

/// Exchanges edges of slivers, between triangles of the same wall: `wall` says of which one a triangle is, if it may
/// change.
pub fn exchange<W: PartialEq>(
    surface: &mut SurfaceMesh,
    wall: impl Fn(usize) -> Option<W>,
    tolerance: f64,
) {
    for _ in 0..ROUNDS {
        let edges = edge_facets(&surface.triangles);
        let mut changed = BTreeSet::new();
        let mut added = BTreeSet::new();
        for (&[a, b], beside) in &edges {
            let [s, t] = beside[..] else { continue };
            if wall(s).is_none()
                || wall(s) != wall(t)
                || changed.contains(&s)
                || changed.contains(&t)
            {
                continue;
            }
            let [first, second] = [s, t].map(|t| surface.triangles[t]);
            let forward = directed_edges(first).contains(&[a, b]);
            let [a, b] = if forward { [a, b] } else { [b, a] };
            let opposite = |t: [usize; 3]| t.into_iter().find(|&v| v != a && v != b);
            let (Some(c), Some(d)) = (opposite(first), opposite(second)) else { continue };
            let key = [c.min(d), c.max(d)];
            if edges.contains_key(&key) || added.contains(&key) {
                continue;
            }
            if is_better(&surface.vertices, [a, b, c, d], tolerance) {
                surface.triangles[s] = [a, d, c];
                surface.triangles[t] = [d, b, c];
                changed.extend([s, t]);
                added.insert(key);
            }
        }
        if added.is_empty() {
            break;
        }
    }
}

/// Whether triangles a d c and d b c are better than a b c and b a d, one of which is a sliver, and as flat.
fn is_better(vertices: &[Vec3], quadrilateral: [usize; 4], tolerance: f64) -> bool {
    let [a, b, c, d] = quadrilateral.map(|v| vertices[v]);
    let doubled = |p: Vec3, q: Vec3, r: Vec3| (q - p).cross(&(r - p));
    let Some(normal) = (doubled(a, b, c) + doubled(b, a, d)).try_normalize(0.0) else {
        return false;
    };
    // Thickness in longest edges; negative upside down.
    let shape = |p: Vec3, q: Vec3, r: Vec3| {
        let longest = [q - p, r - q, p - r].map(|edge| edge.norm_squared());
        doubled(p, q, r).dot(&normal) / longest.into_iter().fold(0.0, f64::max)
    };
    let before = shape(a, b, c).min(shape(b, a, d));
    let after = shape(a, d, c).min(shape(d, b, c));
    let across = (b - a).cross(&(d - c));
    let apart = (c - a).dot(&across).abs();
    before < SLIVER && after > before && apart <= tolerance * across.norm()
}
