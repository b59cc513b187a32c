//! Pairs of surface features that are close to each other.
//!
//! Two triangle surfaces are as far apart as their closest pair of a vertex and
//! a triangle or of two edges. A vertex or edge shared by several triangles is
//! one feature, so every pair occurs once. Pairs that share a vertex are left
//! out: their distance is zero in every shape.

use std::ops::Range;

use mesh::bvh::overlapping_pairs;
use mesh::{Vec3, topology};

use super::distance::{Closest, edge_edge, point_triangle};

/// Vertices, edges and triangles of a set of facets, each once, sorted.
#[derive(Clone, Debug)]
pub struct Features {
    /// Vertex ids.
    pub vertices: Vec<usize>,
    /// Sorted pairs of vertex ids.
    pub edges: Vec<[usize; 2]>,
    /// Triangles as given.
    pub triangles: Vec<[usize; 3]>,
}

impl Features {
    /// The features of a set of facets.
    #[must_use]
    pub fn new(facets: &[[usize; 3]]) -> Self {
        let mut vertices = facets.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        let edges = topology::edge_facets(facets).into_keys().collect();
        Self { vertices, edges, triangles: facets.to_vec() }
    }
}

/// A pair of features by the ids of its four corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// A vertex, then the corners of a triangle.
    PointTriangle([usize; 4]),
    /// The ends of one edge, then those of the other.
    EdgeEdge([usize; 4]),
}

impl Pair {
    /// Vertex ids of the corners.
    #[must_use]
    pub fn corners(&self) -> [usize; 4] {
        match *self {
            Self::PointTriangle(corners) | Self::EdgeEdge(corners) => corners,
        }
    }

    /// How many of the corners, from the start, belong to the first feature.
    #[must_use]
    pub fn corners_of_first(&self) -> usize {
        match self {
            Self::PointTriangle(_) => 1,
            Self::EdgeEdge(_) => 2,
        }
    }

    /// Closest points at corner positions `x` [m].
    #[must_use]
    pub fn closest(&self, x: &[Vec3; 4]) -> Closest {
        match self {
            Self::PointTriangle(_) => point_triangle(x),
            Self::EdgeEdge(_) => edge_edge(x),
        }
    }

    /// The corners' entries of a list over all vertices.
    #[must_use]
    pub fn gather(&self, x: &[Vec3]) -> [Vec3; 4] {
        self.corners().map(|v| x[v])
    }
}

/// All pairs of a feature of `a` and one of `b` closer than `radius` [m] at
/// positions `x`, in a fixed order.
#[must_use]
pub fn pairs_between(a: &Features, b: &Features, x: &[Vec3], radius: f64) -> Vec<Pair> {
    let mut pairs = vertex_triangle(a, b, x, radius);
    pairs.extend(vertex_triangle(b, a, x, radius));
    pairs.extend(edges(a, b, x, radius, |_, _| true));
    pairs
}

/// All pairs of two features of `a` closer than `radius` [m] at positions `x`,
/// in a fixed order.
#[must_use]
pub fn pairs_within(a: &Features, x: &[Vec3], radius: f64) -> Vec<Pair> {
    let mut pairs = vertex_triangle(a, a, x, radius);
    pairs.extend(edges(a, a, x, radius, |i, j| i < j));
    pairs
}

fn vertex_triangle(points: &Features, triangles: &Features, x: &[Vec3], radius: f64) -> Vec<Pair> {
    let candidates = overlapping_pairs(
        &boxes(&points.vertices, x, radius, |&v| [v]),
        &boxes(&triangles.triangles, x, 0.0, |&t| t),
    );
    close(&candidates, x, radius, |i, j| {
        let (p, [a, b, c]) = (points.vertices[i], triangles.triangles[j]);
        (p != a && p != b && p != c).then_some(Pair::PointTriangle([p, a, b, c]))
    })
}

fn edges(
    a: &Features,
    b: &Features,
    x: &[Vec3],
    radius: f64,
    wanted: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<Pair> {
    let candidates =
        overlapping_pairs(&boxes(&a.edges, x, radius, |&e| e), &boxes(&b.edges, x, 0.0, |&e| e));
    close(&candidates, x, radius, |i, j| {
        let ([p, q], [r, s]) = (a.edges[i], b.edges[j]);
        let apart = p != r && p != s && q != r && q != s;
        (apart && wanted(i, j)).then_some(Pair::EdgeEdge([p, q, r, s]))
    })
}

/// Bounding boxes of features, grown by `margin` on all sides.
fn boxes<T, const N: usize>(
    features: &[T],
    x: &[Vec3],
    margin: f64,
    corners: impl Fn(&T) -> [usize; N],
) -> Vec<(Vec3, Vec3)> {
    let grow = Vec3::repeat(margin);
    let bounds = |feature: &T| {
        let points = corners(feature).map(|v| x[v]);
        let (low, high) =
            points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
        (low - grow, high + grow)
    };
    features.iter().map(bounds).collect()
}

/// The candidates that make a pair closer than `radius`, in their order.
fn close(
    candidates: &[(usize, usize)],
    x: &[Vec3],
    radius: f64,
    pair: impl Fn(usize, usize) -> Option<Pair> + Sync,
) -> Vec<Pair> {
    let near = |range: Range<usize>| -> Vec<Pair> {
        let pairs = candidates[range].iter().filter_map(|&(i, j)| pair(i, j));
        pairs.filter(|p| p.closest(&p.gather(x)).d2 < radius * radius).collect()
    };
    let mut result = Vec::new();
    crate::parallel::map_merge(candidates.len(), near, |_, mut part| result.append(&mut part));
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    fn cloud(random: &mut Random, triangles: usize) -> (Vec<Vec3>, Vec<[usize; 3]>) {
        let x = (0..3 * triangles).map(|_| random.vector()).collect();
        (x, (0..triangles).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
    }

    #[test]
    fn pairs_are_those_of_brute_force() {
        let mut random = Random::new(5);
        let (x, facets) = cloud(&mut random, 30);
        let (a, b) = (Features::new(&facets[..12]), Features::new(&facets[12..]));
        let radius = 0.3;
        let mut expected = 0;
        let mut count = |p: &Features, q: &Features, both: bool| {
            for &v in &p.vertices {
                for &[i, j, k] in &q.triangles {
                    let near = point_triangle(&[x[v], x[i], x[j], x[k]]).d2 < radius * radius;
                    expected += usize::from(near);
                }
            }
            for &[i, j] in p.edges.iter().filter(|_| both) {
                for &[k, l] in &q.edges {
                    let near = edge_edge(&[x[i], x[j], x[k], x[l]]).d2 < radius * radius;
                    expected += usize::from(near);
                }
            }
        };
        count(&a, &b, true);
        count(&b, &a, false);
        let found = pairs_between(&a, &b, &x, radius);
        assert!(expected > 100);
        assert_eq!(found.len(), expected);

        let within = pairs_within(&Features::new(&facets), &x, radius).len();
        let separate = pairs_within(&a, &x, radius).len() + pairs_within(&b, &x, radius).len();
        assert_eq!(within, separate + expected);
    }

    #[test]
    fn features_that_share_a_vertex_are_no_pair() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 0.0)];
        let square = Features::new(&[[0, 1, 2], [2, 1, 3]]);
        // left: each far corner with the other triangle, and the two pairs of
        // opposite sides
        assert_eq!(pairs_within(&square, &x, 2.0).len(), 4);
    }
}
