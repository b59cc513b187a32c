//! Tetrahedral meshes.

use crate::Vec3;
use crate::measure::tet_volume;

/// A tetrahedral mesh with straight edges.
///
/// Every tetrahedron has positive volume: det(x₁−x₀, x₂−x₀, x₃−x₀) > 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetMesh {
    /// Vertex positions [m].
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each tetrahedron.
    pub tets: Vec<[usize; 4]>,
}

impl TetMesh {
    /// The four corners of tetrahedron `t` [m].
    pub fn corners(&self, t: usize) -> [Vec3; 4] {
        self.tets[t].map(|v| self.vertices[v])
    }

    /// Signed volume of tetrahedron `t` [m³].
    pub fn volume(&self, t: usize) -> f64 {
        let [a, b, c, d] = self.corners(t);
        tet_volume(a, b, c, d)
    }

    /// Swaps two corners of tetrahedra with negative volume; their number.
    pub fn turn_inverted(&mut self) -> usize {
        let inverted: Vec<usize> = (0..self.tets.len()).filter(|&t| self.volume(t) < 0.0).collect();
        inverted.iter().for_each(|&t| self.tets[t].swap(2, 3));
        inverted.len()
    }
}
