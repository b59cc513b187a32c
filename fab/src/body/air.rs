//! The paths of rising air.

use std::collections::BTreeSet;

use mesh::{TetMesh, Vec3, topology};

/// Points in and on a body, and edges along which air rises in it.
#[derive(Clone, Debug)]
pub struct AirPaths {
    /// The points [m].
    pub points: Vec<Vec3>,
    /// For each, those it is connected with.
    pub neighbours: Vec<Vec<usize>>,
    /// Points on the outer boundary.
    pub outer: BTreeSet<usize>,
}

impl AirPaths {
    /// Along the edges of a volume mesh.
    pub fn within(mesh: &TetMesh, outer: BTreeSet<usize>) -> Self {
        let points = mesh.vertices.clone();
        let edges = topology::tet_edges(&mesh.tets);
        let neighbours = topology::vertex_neighbours(points.len(), &edges);
        Self { points, neighbours, outer }
    }
}
