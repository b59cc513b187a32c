//! Pairs of triangles that meet where they must not.
//!
//! Two triangles meet where an edge of one meets the other. Every edge is asked for the triangles
//! that its segment meets, and not every triangle for its neighbours: the boxes of the triangles around
//! one vertex all overlap, the segments opposite to it do not.

use rayon::prelude::*;

use crate::bvh::BoxTree;
use crate::predicates::{edge_sharing_intersect, segment_intersects_triangle};
use crate::topology::edge_facets;
use crate::{SurfaceMesh, Vec3};

/// All pairs i < j of triangles that meet in more than the vertices and the edge
/// they share, decided exactly; sorted.
///
/// Vertices are shared by index: coincident vertices must have been merged.
pub fn self_intersecting_pairs(surface: &SurfaceMesh) -> Vec<(usize, usize)> {
    let boxes: Vec<_> =
        (0..surface.triangles.len()).map(|t| surface.corners(t)).map(bounds).collect();
    let tree = BoxTree::new(&boxes);
    let edges = edge_facets(&surface.triangles).into_iter();
    let edges: Vec<([usize; 2], Vec<usize>)> = edges.filter(|([a, b], _)| a != b).collect();
    let at_edge = |(ends, beside): &([usize; 2], Vec<usize>)| {
        let mut pairs = Vec::new();
        for (n, &i) in beside.iter().enumerate() {
            let others = beside[n + 1..].iter().map(|&j| (i, j));
            pairs.extend(others.filter(|&(i, j)| folded(surface, *ends, i, j)));
        }
        for j in met_by(surface, &tree, *ends) {
            pairs.extend(beside.iter().map(|&i| (i.min(j), i.max(j))));
        }
        pairs
    };
    let mut pairs: Vec<_> = edges.par_iter().flat_map_iter(at_edge).collect();
    // several edges find the same pair
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs
}

/// Whether two triangles at an edge lie on each other, or are the same twice.
fn folded(surface: &SurfaceMesh, [u, v]: [usize; 2], i: usize, j: usize) -> bool {
    let apex = |t: usize| surface.triangles[t].into_iter().find(|&w| w != u && w != v);
    let (Some(a), Some(b)) = (apex(i), apex(j)) else {
        return false; // degenerate, not intersecting
    };
    let at = |v: usize| &surface.vertices[v];
    a == b || edge_sharing_intersect(at(u), at(v), at(a), at(b))
}

/// The triangles without a vertex of an edge that it meets.
fn met_by(surface: &SurfaceMesh, tree: &BoxTree, ends: [usize; 2]) -> Vec<usize> {
    let [p, q] = ends.map(|v| &surface.vertices[v]);
    let mut met = Vec::new();
    tree.each_met(p, q, |t| {
        let apart = !surface.triangles[t].iter().any(|v| ends.contains(v));
        if apart && segment_intersects_triangle(p, q, &surface.corners(t)) {
            met.push(t);
        }
    });
    met
}

fn bounds([a, b, c]: [Vec3; 3]) -> (Vec3, Vec3) {
    (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicates::tests::{corner_sharing_intersect, triangles_intersect};

    /// Every pair, by the definition.
    fn exhaustive(surface: &SurfaceMesh) -> Vec<(usize, usize)> {
        let meet = |i: usize, j: usize| {
            let (s, t) = (surface.triangles[i], surface.triangles[j]);
            let at = |v: &usize| &surface.vertices[*v];
            let common: Vec<usize> = s.into_iter().filter(|v| t.contains(v)).collect();
            let rest = |triangle: &[usize; 3]| -> Vec<&Vec3> {
                triangle.iter().filter(|v| !common.contains(v)).map(at).collect()
            };
            match (&common[..], &rest(&s)[..], &rest(&t)[..]) {
                ([], _, _) => triangles_intersect(&surface.corners(i), &surface.corners(j)),
                ([v], [a, b], [c, d]) => corner_sharing_intersect(at(v), [a, b], [c, d]),
                ([u, v], [a], [b]) => edge_sharing_intersect(at(u), at(v), a, b),
                _ => true,
            }
        };
        let n = surface.triangles.len();
        let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
        pairs.filter(|&(i, j)| meet(i, j)).collect()
    }

    #[test]
    fn pairs_are_those_of_an_exhaustive_search() {
        // The coordinates of eight to forty vertices are small integers, so that triangles
        // touch, overlap in their plane, share vertices and repeat each other.
        let mut random = 1_u64;
        let mut next = |n: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 33) % n
        };
        let mut found = 0;
        for case in 0..400 {
            let n = 8 + case % 33;
            let vertices = (0..n).map(|_| Vec3::from_fn(|_, _| next(5) as f64)).collect();
            let mut triangles = Vec::new();
            while triangles.len() < 20 {
                let t: [usize; 3] = std::array::from_fn(|_| next(n) as usize);
                if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                    triangles.push(t);
                }
            }
            let surface = SurfaceMesh { vertices, triangles };
            let pairs = self_intersecting_pairs(&surface);
            assert_eq!(pairs, exhaustive(&surface), "case {case}: {surface:?}");
            found += pairs.len();
        }
        assert!(found > 10_000, "{found}");
    }
}
