//! Plane bodies as slabs one layer of elements thick.
//!
//! Vertex v of a plane mesh of n vertices becomes v at z = 0 and n + v at
//! z = thickness. The prism over a triangle with vertices a < b < c is cut into
//! (a, b, c, c'), (a, b, b', c') and (a, a', b', c'): the diagonals of its sides
//! go from the smaller vertex below to the greater one above, so that prisms
//! side by side fit.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use mesh::measure::tet_volume;
use mesh::{SurfaceMesh, TetMesh, Vec3};

use super::selection::Facet;

/// Reads the `v` and `f` lines of an OBJ file with two coordinates, or three
/// of which the last is 0.
pub fn read(path: &Path) -> Result<SurfaceMesh> {
    let text = mesh::io::read_text(path)?;
    let mut plane = SurfaceMesh::default();
    for (line, words) in text.lines().enumerate() {
        let error =
            |what: &str| anyhow!("{}: line {}: {words:?}: {what}", path.display(), line + 1);
        let mut fields = words.split_whitespace();
        match fields.next() {
            Some("v") => {
                let x: Result<Vec<f64>, _> = fields.map(str::parse).collect();
                let x = x.ok().filter(|x| x.iter().all(|c| c.is_finite()));
                match x.as_deref() {
                    Some(&[x, y] | &[x, y, 0.0]) => plane.vertices.push(Vec3::new(x, y, 0.0)),
                    _ => return Err(error("expected x and y of a plane body, and z = 0 if any")),
                }
            }
            Some("f") => {
                let n = plane.vertices.len();
                let index =
                    |w: &str| w.split('/').next()?.parse().ok().filter(|i| (1..=n).contains(i));
                let corners: Option<Vec<usize>> = fields.map(index).collect();
                match corners.as_deref() {
                    Some(&[a, b, c]) => plane.triangles.push([a - 1, b - 1, c - 1]),
                    _ => return Err(error(&format!("expected three vertices from 1 to {n}"))),
                }
            }
            _ => {}
        }
    }
    if plane.triangles.is_empty() {
        bail!("{}: no triangles: expected a triangulation of a plane body", path.display());
    }
    Ok(plane)
}

/// The slab of a plane body; its sides, and its front and back.
pub fn extruded(plane: &SurfaceMesh, thickness: f64) -> (TetMesh, Vec<Facet>, Vec<[usize; 3]>) {
    let n = plane.vertices.len();
    let above = plane.vertices.iter().map(|v| v + thickness * Vec3::z());
    let vertices: Vec<Vec3> = plane.vertices.iter().copied().chain(above).collect();
    let mut tets = Vec::with_capacity(3 * plane.triangles.len());
    for &triangle in &plane.triangles {
        let [a, b, c] = mesh::facet_key(triangle);
        tets.extend([[a, b, c, n + c], [a, b, n + b, n + c], [a, n + a, n + b, n + c]]);
    }
    for tet in &mut tets {
        let [a, b, c, d] = tet.map(|v| vertices[v]);
        if tet_volume(a, b, c, d) < 0.0 {
            tet.swap(2, 3);
        }
    }
    let mesh = TetMesh { vertices, tets };
    let (mut sides, mut faces) = (Vec::new(), Vec::new());
    for corners in mesh::topology::boundary(&mesh).facets {
        let mut source: Vec<usize> = corners.iter().map(|v| v % n).collect();
        source.sort_unstable();
        source.dedup();
        if source.len() == 3 {
            faces.push(corners);
            continue;
        }
        let center = source.iter().map(|&v| plane.vertices[v]).sum::<Vec3>() / 2.0;
        sides.push(Facet { corners, source, center });
    }
    (mesh, sides, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_files_are_read_with_two_or_three_coordinates() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("plane.obj");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("writable");
            read(&path)
        };
        let plane = read("# x\nv 0 0\nv 1 0 0\nv 0 1\nf 1/1 2 3\n").expect("plane");
        assert_eq!(plane.triangles, [[0, 1, 2]]);
        for (text, words) in [
            ("v 0 0 1\n", "line 1: \"v 0 0 1\": expected x and y"),
            ("v 0 0\nf 1 2 3\n", "line 2: \"f 1 2 3\": expected three vertices from 1 to 1"),
            ("v 0 0\n", "no triangles"),
        ] {
            let message = read(text).expect_err(text).to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
