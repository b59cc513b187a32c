//! The boundary of a tetrahedral mesh as selectors see it.

use mesh::{TetMesh, Vec3, measure, topology};

/// Boundary facets with what a selector may ask about them.
pub struct Facets {
    /// Vertex ids of the tetrahedral mesh, counter-clockwise from outside.
    pub triangles: Vec<[usize; 3]>,
    /// Centroid of each facet [m].
    pub centroids: Vec<Vec3>,
    /// Unit outward normal of each facet.
    pub normals: Vec<Vec3>,
    /// Area of each facet [m²].
    pub areas: Vec<f64>,
    /// Vertices of the tetrahedral mesh [m].
    pub vertices: Vec<Vec3>,
}

impl Facets {
    /// The facets of `mesh` that belong to exactly one tetrahedron.
    pub fn of(mesh: &TetMesh) -> Self {
        let triangles = topology::boundary(mesh).facets;
        let corners = |t: &[usize; 3]| t.map(|v| mesh.vertices[v]);
        Self {
            centroids: triangles.iter().map(corners).map(|[a, b, c]| (a + b + c) / 3.0).collect(),
            normals: triangles
                .iter()
                .map(corners)
                .map(|[a, b, c]| measure::triangle_normal(a, b, c))
                .collect(),
            areas: triangles
                .iter()
                .map(corners)
                .map(|[a, b, c]| measure::triangle_area(a, b, c))
                .collect(),
            vertices: mesh.vertices.clone(),
            triangles,
        }
    }

    /// The least height of a facet [m].
    pub fn height(&self, facet: usize) -> f64 {
        let [a, b, c] = self.triangles[facet].map(|v| self.vertices[v]);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        2.0 * self.areas[facet] / longest
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there is no facet.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }
}
