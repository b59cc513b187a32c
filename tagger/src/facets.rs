//! The boundary of a tetrahedral mesh as selectors see it.

use mesh::{SurfaceMesh, TetMesh, Vec3, measure, topology};

/// Boundary facets with what a selector may ask about them.
pub struct Facets {
    /// The facets, with all vertices of the tetrahedral mesh.
    pub surface: SurfaceMesh,
    /// Centroid of each facet [m].
    pub centroids: Vec<Vec3>,
}

impl Facets {
    /// The facets of `mesh` that belong to exactly one tetrahedron.
    pub fn of(mesh: &TetMesh) -> Self {
        let (vertices, triangles) = (mesh.vertices.clone(), topology::boundary(mesh).facets);
        let surface = SurfaceMesh { vertices, triangles };
        let centroids = (0..surface.triangles.len()).map(|f| surface.centroid(f)).collect();
        Self { surface, centroids }
    }

    /// The least height of a facet [m].
    pub fn height(&self, facet: usize) -> f64 {
        2.0 * self.surface.area(facet) / measure::longest_edge(self.surface.corners(facet))
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.surface.triangles.len()
    }

    /// Whether there is no facet.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Area of facets of a mesh [m²].
pub fn area(mesh: &TetMesh, facets: &[[usize; 3]]) -> f64 {
    measure::area(&topology::submesh(&mesh.vertices, facets).0)
}
