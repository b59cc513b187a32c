//! Rules for tetrahedral meshes.

use super::{Finding, at, lost, not_finite};
use crate::topology::TET_FACETS;
use crate::{TetMesh, facet_key};

/// What is wrong with a tetrahedral mesh: it is empty or not finite, indices do
/// not exist, volumes are not positive, more than two tetrahedra or two on the
/// same side share a facet, vertices are used by no tetrahedron.
pub fn check_tets(mesh: &TetMesh) -> Vec<Finding> {
    let unusable: Vec<Finding> =
        [not_finite(&mesh.vertices, "mesh"), indices(mesh)].into_iter().flatten().collect();
    if !unusable.is_empty() {
        return unusable;
    }
    [volumes(mesh), conforming(mesh), unused(mesh)].into_iter().flatten().collect()
}

fn indices(mesh: &TetMesh) -> Option<Finding> {
    let n = mesh.vertices.len();
    if mesh.tets.is_empty() {
        let message = format!("the mesh is empty: {n} vertices, no tetrahedra");
        return Some(Finding::new("indices", 1, message));
    }
    lost("indices", &mesh.tets, n, ["tetrahedra", "tetrahedron"])
}

fn volumes(mesh: &TetMesh) -> Option<Finding> {
    let bad: Vec<usize> = (0..mesh.tets.len()).filter(|&t| mesh.volume(t) <= 0.0).collect();
    let (&t, count) = (bad.first()?, bad.len());
    let centroid = mesh.corners(t).iter().sum::<crate::Vec3>() / 4.0;
    let message = format!(
        "{count} of {} tetrahedra have no positive volume, first tetrahedron {t} with {:.3e} m³ \
         at {}",
        mesh.tets.len(),
        mesh.volume(t),
        at(&centroid)
    );
    Some(Finding::new("volume", count, message))
}

/// With positive volumes, two tetrahedra on different sides of a facet see it
/// with opposite orientations.
fn conforming(mesh: &TetMesh) -> Option<Finding> {
    let mut sides: Vec<([usize; 3], bool)> = mesh
        .tets
        .iter()
        .flat_map(|tet| TET_FACETS.map(|corners| corners.map(|c| tet[c])))
        .map(|facet| (facet_key(facet), is_even(facet)))
        .collect();
    sides.sort_unstable();
    let mut crowded: Vec<[usize; 3]> =
        sides.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0].0).collect();
    crowded.dedup();
    let (&[a, b, c], count) = (crowded.first()?, crowded.len());
    let centroid = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3.0;
    let message = format!(
        "{count} facets have two tetrahedra on the same side, first facet {a}-{b}-{c} at {}",
        at(&centroid)
    );
    Some(Finding::new("conforming", count, message))
}

/// Whether the vertices are an even permutation of their ascending order.
fn is_even([a, b, c]: [usize; 3]) -> bool {
    !((a < b) ^ (b < c) ^ (c < a))
}

fn unused(mesh: &TetMesh) -> Option<Finding> {
    let mut used = vec![false; mesh.vertices.len()];
    for &v in mesh.tets.iter().flatten() {
        used[v] = true;
    }
    let unused: Vec<usize> = (0..used.len()).filter(|&v| !used[v]).collect();
    let (&v, count) = (unused.first()?, unused.len());
    let message = format!(
        "{count} of {} vertices belong to no tetrahedron, first vertex {v} at {}",
        mesh.vertices.len(),
        at(&mesh.vertices[v])
    );
    Some(Finding::new("unused", count, message))
}
