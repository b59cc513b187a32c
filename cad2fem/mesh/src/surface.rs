//! Triangle surfaces.

use crate::Vec3;
use crate::measure::{triangle_area, triangle_normal};

/// A triangle surface, open or closed.
///
/// Triangles are counter-clockwise seen from outside the solid they bound, so
/// that (b − a) × (c − a) points out of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Vertex positions [m].
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[usize; 3]>,
}

impl SurfaceMesh {
    /// The three corners of triangle `t` [m].
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|v| self.vertices[v])
    }

    /// Centroid of triangle `t` [m].
    pub fn centroid(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners(t);
        (a + b + c) / 3.0
    }

    /// Unit normal of triangle `t`, out of the solid; zero for one without area.
    pub fn normal(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners(t);
        triangle_normal(a, b, c)
    }

    /// Area of triangle `t` [m²].
    pub fn area(&self, t: usize) -> f64 {
        let [a, b, c] = self.corners(t);
        triangle_area(a, b, c)
    }

    /// Adds the triangles of another surface, with vertices of their own.
    pub fn append(&mut self, other: &Self) {
        let first = self.vertices.len();
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }
}
