//! How a design moved the boundary of its mesh, read from the files.

use std::path::Path;

use mesh::bvh::SurfaceBvh;
use mesh::io::read_tets;
use mesh::measure::triangle_normal;
use mesh::{SurfaceMesh, Vec3, topology};
use nalgebra::Matrix3;

use super::origins::Origins;

/// Least cosine between the normal of a vertex and that of the CAD beside it: not at sharp edges.
const ALIKE: f64 = 0.9;

/// The boundary of a mesh as modelled and as designed, with the same facets.
pub struct Motion {
    modelled: SurfaceMesh,
    design: SurfaceMesh,
}

impl Motion {
    /// Reads the mesh as modelled at `path` and the design.
    pub fn new(path: &Path, origins: &Origins) -> Result<Self, String> {
        let read = |path: &Path| read_tets(path).map_err(|e| e.to_string());
        let [modelled, design] = [read(path)?.mesh, read(&origins.design)?.mesh];
        let facets = topology::boundary(&modelled).facets;
        if facets != topology::boundary(&design).facets {
            return Err("the design has other facets than the mesh as modelled".into());
        }
        let of = |vertices| SurfaceMesh { vertices, triangles: facets.clone() };
        Ok(Self { modelled: of(modelled.vertices), design: of(design.vertices) })
    }

    /// The points of the CAD that are nearest to vertices which moved, as far from the design along its normal as they
    /// were from the mesh. Vertices beside sharp edges are left out.
    pub fn carried(&self, model: &SurfaceMesh) -> Vec<Vec3> {
        let bvh = SurfaceBvh::new(model);
        let [before, after] = [&self.modelled, &self.design].map(normals);
        let carried = |v: usize| {
            let (start, end) = (self.modelled.vertices[v], self.design.vertices.get(v)?);
            if start == *end || before[v] == Vec3::zeros() {
                return None;
            }
            let near = bvh.closest(&start);
            let [a, b, c] = model.corners(near.triangle);
            let is_smooth = triangle_normal(a, b, c).dot(&before[v]) >= ALIKE;
            is_smooth.then(|| end + after[v] * (near.point - start).dot(&before[v]))
        };
        (0..self.modelled.vertices.len()).filter_map(carried).collect()
    }

    /// How far the motion bends between the vertices, at most: by the jump of its gradient at an edge of a facet, times an
    /// eighth of the edge, as of a motion of second order [m].
    pub fn bends(&self) -> f64 {
        let gradient = |t: usize| {
            let [a, b, c] = self.modelled.corners(t);
            let facet = self.modelled.triangles[t];
            let motion = facet.map(|v| self.design.vertices[v] - self.modelled.vertices[v]);
            let normal = triangle_normal(a, b, c);
            let steps = Matrix3::from_columns(&[b - a, c - a, normal]);
            let by = Matrix3::from_columns(&[
                motion[1] - motion[0],
                motion[2] - motion[0],
                Vec3::zeros(),
            ]);
            by * steps.try_inverse().unwrap_or_default()
        };
        let edges = topology::edge_facets(&self.modelled.triangles);
        let bend = |([a, b], facets): (&[usize; 2], &Vec<usize>)| match facets[..] {
            [s, t] => {
                let length = (self.modelled.vertices[*b] - self.modelled.vertices[*a]).norm();
                (gradient(s) - gradient(t)).norm() * length / 8.0
            }
            _ => 0.0,
        };
        edges.iter().map(bend).fold(0.0, f64::max)
    }
}

/// The mean normals of the facets at each vertex; zero where there are none.
fn normals(surface: &SurfaceMesh) -> Vec<Vec3> {
    let mut all = vec![Vec3::zeros(); surface.vertices.len()];
    for (t, facet) in surface.triangles.iter().enumerate() {
        let [a, b, c] = surface.corners(t);
        facet.iter().for_each(|&v| all[v] += (b - a).cross(&(c - a)));
    }
    all.into_iter().map(|sum| sum.try_normalize(0.0).unwrap_or_default()).collect()
}
