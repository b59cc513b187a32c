//! Facets inside a body that lie on an open surface, such as a sheet of paper in a floor.
//!
//! A facet lies on the surface if its two tetrahedra are on different sides of it, by their
//! centroids and the normal of the nearest triangle, and its vertices are within ε. What is selected
//! so is one layer, without holes: slivers, whose four vertices are all near, belong to one side.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use mesh::bvh::SurfaceBvh;
use mesh::topology::TET_FACETS;
use mesh::{SurfaceMesh, TetMesh, Vec3, facet_key};
use program::Unusable;

/// A facet that leaves the surface by more than ε counts where it is seen along the normal, to
/// this cosine: beyond a rim it is not.
const ALONG: f64 = 0.999;

/// The facets on a surface, sorted.
pub fn select(
    mesh: &TetMesh,
    surface: &SurfaceMesh,
    file: &Path,
    epsilon: f64,
) -> Result<Vec<[usize; 3]>> {
    let bvh = SurfaceBvh::new(surface);

    // Height above the nearest triangle, and distance [m].
    let seen = |p: &Vec3| {
        let near = bvh.closest(p);
        (surface.normal(near.triangle).dot(&(p - near.point)), near.distance)
    };
    let heights: Vec<f64> = (0..mesh.tets.len())
        .map(|t| seen(&(mesh.corners(t).iter().sum::<Vec3>() / 4.0)).0)
        .collect();
    let (mut on, mut beside) = (Vec::new(), Vec::new());
    for facet in between(mesh, &heights) {
        let corners = facet.map(|v| seen(&mesh.vertices[v]));
        let farthest = corners.iter().map(|&(_, d)| d).fold(0.0, f64::max);
        let along = |&(height, distance): &(f64, f64)| height.abs() >= ALONG * distance;
        if farthest <= epsilon {
            on.push(facet);
        } else if corners.iter().all(along) {
            beside.push(farthest);
        }
    }
    let advice =
        format!("mesh it with: cad2fem tetmesh SURFACE --inside {} -o OUT.msh", file.display());
    let farthest = beside.iter().copied().fold(0.0, f64::max);
    if on.is_empty() || !beside.is_empty() {
        return Err(Unusable(format!(
            "{} facets inside the mesh lie within epsilon = {epsilon:.3e} m of {}, {} between its two \
             sides do not, by up to {farthest:.3e} m: the mesh does not follow this surface; {advice}",
            on.len(),
            file.display(),
            beside.len()
        ))
        .into());
    }
    on.sort_unstable();
    Ok(on)
}

/// Facets whose tetrahedra have heights of different signs.
fn between(mesh: &TetMesh, heights: &[f64]) -> Vec<[usize; 3]> {
    let mut first = BTreeMap::new();
    let mut found = Vec::new();
    for (t, tet) in mesh.tets.iter().enumerate() {
        for facet in TET_FACETS {
            let facet = facet_key(facet.map(|c| tet[c]));
            if let Some(other) = first.insert(facet, t)
                && (heights[t] > 0.0) != (heights[other] > 0.0)
            {
                found.push(facet);
            }
        }
    }
    found
}
