//! No two vertices of a tetrahedral mesh are at the same place, or next to it.
//!
//! A mesher that makes its boundary manifold doubles a vertex at which the body touches itself:
//! each tetrahedron is sound, but the boundary crosses itself there.

use std::collections::HashMap;

use super::{Finding, at};
use crate::{TetMesh, Vec3, topology};

/// Vertices nearer than this part of the mean edge are at one place: single precision, which binary
/// STL has, keeps 6·10⁻⁸ of the size of a body, of which a mean edge is some hundredths.
const NEAR: f64 = 1e-5;

/// The vertices of a mesh with finite coordinates that are at the place of an earlier one of the same
/// body; bodies may touch.
pub fn coincident(mesh: &TetMesh) -> Option<Finding> {
    let edges = topology::tet_edges(&mesh.tets);
    let length = |&[a, b]: &[usize; 2]| (mesh.vertices[b] - mesh.vertices[a]).norm();
    let near = NEAR * edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64;
    let bodies = bodies(mesh);
    let cell = |p: &Vec3, offset: [i64; 3]| {
        let index = |axis: usize| (p[axis] / near).floor() as i64;
        [0, 1, 2].map(|axis| index(axis).saturating_add(offset[axis]))
    };
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut pairs = Vec::new();
    for (v, place) in mesh.vertices.iter().enumerate() {
        let around = (0..27).map(|i| cell(place, [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]));
        let others = around.filter_map(|key| cells.get(&key)).flatten();
        let distance = |&u: &usize| (mesh.vertices[u] - place).norm();
        let others = others.copied().filter(|&u| bodies[u] == bodies[v]);
        let nearest = others.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        pairs.extend(nearest.filter(|u| distance(u) <= near).map(|u| (distance(&u), u, v)));
        cells.entry(cell(place, [0; 3])).or_default().push(v);
    }
    let (&(distance, u, v), count) = (pairs.first()?, pairs.len());
    let message = format!(
        "{count} of {} vertices are at the place of another, nearer than {near:.1e} m ({NEAR:.0e} of the mean \
         edge): first {u} and {v}, {distance:.1e} m apart, at {}",
        mesh.vertices.len(),
        at(&mesh.vertices[v])
    );
    Some(Finding { rule: "coincident", message, count })
}

/// For each vertex the number of its body, whose tetrahedra share facets.
fn bodies(mesh: &TetMesh) -> Vec<usize> {
    // Two triangles of each tetrahedron: those of neighbours have an edge in common.
    let sides = |&[a, b, c, d]: &[usize; 4]| [[a, b, c], [a, b, d]];
    let triangles: Vec<[usize; 3]> = mesh.tets.iter().flat_map(sides).collect();
    let mut body = vec![0; mesh.vertices.len()];
    for (number, part) in topology::components(&triangles).iter().enumerate() {
        part.iter().flat_map(|&t| triangles[t]).for_each(|v| body[v] = number);
    }
    body
}
