//! Improvement that keeps surfaces inside a mesh: it is slit along them, so that both sides of each
//! become boundary, and closed again.

use std::collections::{BTreeMap, BTreeSet};

use super::{ImproveReport, improve_interior};
use crate::topology::TET_FACETS;
use crate::{TetMesh, facet_key};

/// [`improve_interior`], with some facets inside that stay as they are, bit for bit. Their
/// vertices and those of the boundary keep their numbers.
pub fn improve_around(
    mesh: &mut TetMesh,
    inside: &BTreeSet<[usize; 3]>,
    passes: usize,
) -> ImproveReport {
    let count = mesh.vertices.len();
    let twins = slit(mesh, inside);
    let report = improve_interior(mesh, passes);
    // The twins are boundary and have kept their numbers; what was added follows them.
    let shift = |v: usize| match twins.get(v.wrapping_sub(count)) {
        Some(&original) => original,
        None if v >= count => v - twins.len(),
        None => v,
    };
    for tet in &mut mesh.tets {
        *tet = tet.map(shift);
    }
    mesh.vertices.drain(count..count + twins.len());
    report
}

/// Gives each vertex a twin on every further side of the facets inside; these come last. For each
/// twin the vertex that it stands for.
fn slit(mesh: &mut TetMesh, inside: &BTreeSet<[usize; 3]>) -> Vec<usize> {
    let mut sides: BTreeMap<[usize; 3], usize> = BTreeMap::new();
    // Corners of tetrahedra, 4 t + c; those of one vertex on one side of all facets are joined.
    let mut parent: Vec<usize> = (0..4 * mesh.tets.len()).collect();
    for (t, tet) in mesh.tets.iter().enumerate() {
        for facet in TET_FACETS {
            let key = facet_key(facet.map(|c| tet[c]));
            if inside.contains(&key) {
                continue;
            }
            let Some(other) = sides.insert(key, t) else { continue };
            for c in facet {
                let twin = mesh.tets[other].iter().position(|v| *v == tet[c]);
                let twin = twin.expect("both tetrahedra have the facet");
                let (a, b) = (root(&mut parent, 4 * t + c), root(&mut parent, 4 * other + twin));
                parent[a.max(b)] = a.min(b);
            }
        }
    }
    let mut number = BTreeMap::new();
    let mut taken = vec![false; mesh.vertices.len()];
    let mut twins = Vec::new();
    for t in 0..mesh.tets.len() {
        for c in 0..4 {
            let v = mesh.tets[t][c];
            let side = root(&mut parent, 4 * t + c);
            let new = *number.entry(side).or_insert_with(|| {
                if !taken[v] {
                    taken[v] = true;
                    return v;
                }
                twins.push(v);
                taken.len() + twins.len() - 1
            });
            mesh.tets[t][c] = new;
        }
    }
    mesh.vertices.extend(twins.iter().map(|&v| mesh.vertices[v]).collect::<Vec<_>>());
    twins
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}
