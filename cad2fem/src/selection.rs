//! Open patch → closed selection volume.
//!
//! Every vertex is moved by ±distance along its normal, the mean of the normals of
//! its triangles weighted by their angles at the vertex; side walls join the two
//! copies along the rim. A closed patch becomes a shell with two surfaces.

use anyhow::{Result, bail, ensure};
use mesh::topology::boundary_edges;
use mesh::{SurfaceMesh, Vec3, check};
use program::Unusable;

use mesh::check::findings;

/// The volume within `distance` [m] of `patch` along its normals.
pub fn offset(patch: &SurfaceMesh, distance: f64) -> Result<SurfaceMesh> {
    ensure!(
        distance > 0.0 && distance.is_finite(),
        "the distance must be positive, found {distance} m"
    );
    let found = check::run(patch, &["degenerate", "manifold"]);
    if !found.is_empty() {
        bail!("no thickness can be given to this patch:{}", findings(&found));
    }
    let normals = vertex_normals(patch)?;
    let moved = |sign: f64| {
        patch.vertices.iter().zip(&normals).map(move |(v, n)| v + n * (sign * distance))
    };
    let n = patch.vertices.len();
    let mut triangles = patch.triangles.clone();
    triangles.extend(patch.triangles.iter().map(|&[a, b, c]| [n + a, n + c, n + b]));
    for [a, b] in boundary_edges(&patch.triangles) {
        triangles.push([n + a, n + b, b]);
        triangles.push([n + a, b, a]);
    }
    let volume = SurfaceMesh { vertices: moved(1.0).chain(moved(-1.0)).collect(), triangles };
    let found = check::run(&volume, &["closed", "manifold"]);
    if !found.is_empty() {
        return Err(Unusable(format!("the volume is not closed:{}", findings(&found))).into());
    }
    Ok(volume)
}

/// Unit normals at the vertices, weighted by angles.
fn vertex_normals(surface: &SurfaceMesh) -> Result<Vec<Vec3>> {
    let mut normals = vec![Vec3::zeros(); surface.vertices.len()];
    for (t, triangle) in surface.triangles.iter().enumerate() {
        let corners = surface.corners(t);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
        for k in 0..3 {
            let [p, q, r] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
            normals[triangle[k]] += normal * (q - p).angle(&(r - p));
        }
    }
    for (v, normal) in normals.iter_mut().enumerate() {
        // Below the sum of two opposite unit normals nothing but rounding is left.
        ensure!(
            normal.norm() > 1e-9,
            "vertex {v} at {:?} m has no normal: its triangles face opposite ways or it has none",
            surface.vertices[v].as_slice()
        );
        normal.normalize_mut();
    }
    Ok(normals)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_patch_with_three_triangles_at_an_edge_is_refused() {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z()];
        let patch = SurfaceMesh { vertices, triangles: vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]] };
        let message = offset(&patch, 0.01).unwrap_err().to_string();
        assert!(message.contains("manifold"), "{message}");
    }
}
