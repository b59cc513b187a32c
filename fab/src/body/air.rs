//! The paths of rising air.

use std::collections::BTreeSet;

use mesh::{SurfaceMesh, TetMesh, Vec3, topology};

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

    /// Along the edges of a surface, where there is no volume mesh. A local maximum of the
    /// surface need not be one of the volume: there may be a vent too many.
    pub fn on(surface: &SurfaceMesh) -> Self {
        let points = surface.vertices.clone();
        let edges: Vec<[usize; 2]> =
            topology::edge_facets(&surface.triangles).into_keys().collect();
        let neighbours = topology::vertex_neighbours(points.len(), &edges);
        let outer = (0..points.len()).collect();
        Self { points, neighbours, outer }
    }
}
