//! Features of a surface and pairs of them.
//!
//! Two triangle surfaces are as far apart as their closest pair of a vertex and
//! a triangle or of two edges. A vertex or edge shared by several triangles is
//! one feature, so every pair occurs once. Pairs that share a vertex are left
//! out: their distance is zero in every shape.

use std::ops::Range;

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
    pub fn new(facets: &[[usize; 3]]) -> Self {
        let mut vertices = facets.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        let edges = topology::edge_facets(facets).into_keys().collect();
        Self { vertices, edges, triangles: facets.to_vec() }
    }
}

/// Facets, found by their vertices.
#[derive(Clone, Debug)]
pub struct Facets {
    all: Vec<[usize; 3]>,
    /// Which of them are at each vertex.
    at: Vec<Vec<usize>>,
}

impl Facets {
    /// The facets of a mesh with so many vertices.
    pub fn new(facets: Vec<[usize; 3]>, vertices: usize) -> Self {
        let mut at = vec![Vec::new(); vertices];
        for (f, facet) in facets.iter().enumerate() {
            facet.iter().for_each(|&v| at[v].push(f));
        }
        Self { all: facets, at }
    }

    /// All of them.
    pub fn all(&self) -> &[[usize; 3]] {
        &self.all
    }

    /// Unit normal of one at positions `x` [1].
    pub fn normal(&self, facet: usize, x: &[Vec3]) -> Vec3 {
        let [a, b, c] = self.all[facet].map(|v| x[v]);
        (b - a).cross(&(c - a)).normalize()
    }

    /// Those that both closest points of a pair lie on.
    pub fn ends(&self, pair: &Pair, closest: &Closest) -> [Vec<usize>; 2] {
        let first = pair.corners_of_first();
        let at = |corners: Range<usize>| {
            let closest = corners.filter(|&i| closest.coefficients[i] != 0.0);
            self.with(&closest.map(|i| pair.corners()[i]).collect::<Vec<_>>())
        };
        [at(0..first), at(first..4)]
    }

    /// Those that have all these vertices.
    fn with(&self, vertices: &[usize]) -> Vec<usize> {
        let Some((first, others)) = vertices.split_first() else { return Vec::new() };
        let has_all = |f: &&usize| others.iter().all(|v| self.all[**f].contains(v));
        self.at[*first].iter().filter(has_all).copied().collect()
    }
}

/// A pair of features by the ids of its four corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Pair {
    /// A vertex, then the corners of a triangle.
    PointTriangle([usize; 4]),
    /// The ends of one edge, then those of the other.
    EdgeEdge([usize; 4]),
}

impl Pair {
    /// Vertex ids of the corners.
    pub fn corners(&self) -> [usize; 4] {
        match *self {
            Self::PointTriangle(corners) | Self::EdgeEdge(corners) => corners,
        }
    }

    /// How many of the corners, from the start, belong to the first feature.
    pub fn corners_of_first(&self) -> usize {
        match self {
            Self::PointTriangle(_) => 1,
            Self::EdgeEdge(_) => 2,
        }
    }

    /// Closest points at corner positions `x` [m].
    pub fn closest(&self, x: &[Vec3; 4]) -> Closest {
        match self {
            Self::PointTriangle(_) => point_triangle(x),
            Self::EdgeEdge(_) => edge_edge(x),
        }
    }

    /// The corners' entries of a list over all vertices.
    pub fn gather(&self, x: &[Vec3]) -> [Vec3; 4] {
        self.corners().map(|v| x[v])
    }
}
