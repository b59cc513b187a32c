//! Pairs of triangles that meet where they must not.
//!
//! Two triangles meet where an edge of one meets the other. Every edge is asked for the triangles
//! that its segment meets, and not every triangle for its neighbours: the boxes of the thousands of
//! triangles around one vertex all overlap, the segments opposite to it do not.

use rayon::prelude::*;

use crate::bvh::BoxTree;
use crate::predicates::{edge_sharing_intersect, segment_intersects_triangle};
use crate::topology::edge_facets;
use crate::{SurfaceMesh, Vec3};

/// Triangles around a vertex with more of them are in a tree of their own.
const CROWDED: usize = 512;

/// Edges that are asked at first before pairs are counted; twice as many each time.
const FIRST_BATCH: usize = 64;

/// All pairs i < j of triangles that meet in more than the vertices and the edge
/// they share, decided exactly; sorted.
///
/// Vertices are shared by index: coincident vertices must have been merged.
pub fn self_intersecting_pairs(surface: &SurfaceMesh) -> Vec<(usize, usize)> {
    some_self_intersecting_pairs(surface, usize::MAX)
}

/// As [`self_intersecting_pairs`]; where there are more than `most`, `most` or some more of them. A
/// surface may have half of the square of its number of triangles.
pub fn some_self_intersecting_pairs(surface: &SurfaceMesh, most: usize) -> Vec<(usize, usize)> {
    let edges = Edges::new(surface);
    let mut pairs = edges.folded(surface, most);
    pairs.par_sort_unstable();
    pairs.dedup();
    let trees = Trees::new(surface);
    let (mut begin, mut batch) = (0, FIRST_BATCH);
    while begin < edges.0.len() && pairs.len() < most {
        let end = (begin + batch).min(edges.0.len());
        let found = (begin..end).into_par_iter();
        pairs.par_extend(found.flat_map_iter(|e| edges.pairs_at(e, surface, &trees)));
        // several edges find the same pair
        pairs.par_sort_unstable();
        pairs.dedup();
        (begin, batch) = (end, 2 * batch);
    }
    pairs
}

/// The edges of a surface: ends, ascending, and triangles.
struct Edges(Vec<([usize; 2], Vec<usize>)>);

impl Edges {
    fn new(surface: &SurfaceMesh) -> Self {
        let all = edge_facets(&surface.triangles).into_iter();
        Self(all.filter(|([a, b], _)| a != b).collect())
    }

    /// Pairs that share an edge and are folded onto each other there, or are the same twice.
    fn folded(&self, surface: &SurfaceMesh, most: usize) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for (ends, beside) in &self.0 {
            for (n, &i) in beside.iter().enumerate() {
                if pairs.len() >= most {
                    return pairs;
                }
                let others = beside[n + 1..].iter().map(|&j| (i, j));
                pairs.extend(others.filter(|&(i, j)| folded(surface, *ends, i, j)));
            }
        }
        pairs
    }

    /// Pairs of the triangles at an edge with those that its inside or its ends meet.
    fn pairs_at(&self, e: usize, surface: &SurfaceMesh, trees: &Trees) -> Vec<(usize, usize)> {
        let ([a, b], beside) = &self.0[e];
        let met = trees.met_by(surface, *a, *b);
        let both = |&j: &usize| beside.iter().map(move |&i| (i.min(j), i.max(j)));
        met.iter().flat_map(both).collect()
    }
}

/// Whether two triangles at an edge lie on each other.
fn folded(surface: &SurfaceMesh, [u, v]: [usize; 2], i: usize, j: usize) -> bool {
    let apex = |t: usize| surface.triangles[t].into_iter().find(|&w| w != u && w != v);
    let (Some(a), Some(b)) = (apex(i), apex(j)) else {
        return false; // degenerate, not intersecting
    };
    let at = |v: usize| &surface.vertices[v];
    a == b || edge_sharing_intersect(at(u), at(v), at(a), at(b))
}

/// All triangles, those around a crowded vertex apart.
struct Trees {
    groups: Vec<Group>,
}

struct Group {
    /// A vertex that all its triangles have.
    hub: Option<usize>,
    triangles: Vec<usize>,
    tree: BoxTree,
}

impl Trees {
    fn new(surface: &SurfaceMesh) -> Self {
        let mut valence = vec![0; surface.vertices.len()];
        surface.triangles.iter().flatten().for_each(|&v| valence[v] += 1);
        let hub = |t: &usize| {
            let most = surface.triangles[*t].into_iter().max_by_key(|&v| (valence[v], v));
            most.filter(|&v| valence[v] > CROWDED)
        };
        let mut order: Vec<usize> = (0..surface.triangles.len()).collect();
        order.sort_by_key(hub);
        let groups = order.chunk_by(|s, t| hub(s) == hub(t)).map(|same| {
            let boxes: Vec<_> = same.iter().map(|&t| surface.corners(t)).map(bounds).collect();
            Group { hub: hub(&same[0]), triangles: same.to_vec(), tree: BoxTree::new(&boxes) }
        });
        Self { groups: groups.collect() }
    }

    /// The triangles without a vertex of the edge ab that it meets.
    fn met_by(&self, surface: &SurfaceMesh, a: usize, b: usize) -> Vec<usize> {
        let (p, q) = (&surface.vertices[a], &surface.vertices[b]);
        let mut met = Vec::new();
        for group in self.groups.iter().filter(|g| g.hub.is_none_or(|hub| hub != a && hub != b)) {
            group.tree.each_met(p, q, |leaf| {
                let t = group.triangles[leaf];
                let corners = surface.triangles[t];
                if !corners.contains(&a)
                    && !corners.contains(&b)
                    && segment_intersects_triangle(p, q, &surface.corners(t))
                {
                    met.push(t);
                }
            });
        }
        met
    }
}

fn bounds([a, b, c]: [Vec3; 3]) -> (Vec3, Vec3) {
    (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::time::Instant;

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

    /// Two cones with a common rim of `n` edges.
    fn spindle(n: usize) -> SurfaceMesh {
        let mut vertices = vec![Vec3::z(), -Vec3::z()];
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        vertices.extend((0..n).map(|i| Vec3::new(angle(i).cos(), angle(i).sin(), 0.0)));
        let side = |i: usize| (2 + i, 2 + (i + 1) % n);
        let triangles = (0..n).flat_map(|i| {
            let (a, b) = side(i);
            [[0, a, b], [1, b, a]]
        });
        SurfaceMesh { vertices, triangles: triangles.collect() }
    }

    #[test]
    fn crowded_vertices_and_coincident_triangles_take_no_square_of_time() {
        // 23 s and 76 s at 5000 and 20 000 before; two seconds are for a busy machine
        let start = Instant::now();
        assert_eq!(self_intersecting_pairs(&spindle(20_000)), []);
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
        let coincident = SurfaceMesh { vertices, triangles: vec![[0, 1, 2]; 20_000] };
        let most = 1_000_000;
        assert!(some_self_intersecting_pairs(&coincident, most).len() >= most);
        let corners = coincident.vertices.iter().cycle().take(60_000).copied().collect();
        let triangles = (0..20_000).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let apart = SurfaceMesh { vertices: corners, triangles };
        assert!(some_self_intersecting_pairs(&apart, most).len() >= most);
        let seconds = start.elapsed().as_secs_f64();
        assert!(seconds < if cfg!(debug_assertions) { 20.0 } else { 2.0 }, "{seconds} s");
    }
}
