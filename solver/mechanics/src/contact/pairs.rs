//! Features of a surface and pairs of them.
//!
//! Two triangle surfaces are as far apart as their closest pair of a vertex and
//! a triangle or of two edges. A vertex or edge shared by several triangles is
//! one feature, so every pair occurs once. Pairs that share a vertex are left
//! out: their distance is zero in every shape.

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
