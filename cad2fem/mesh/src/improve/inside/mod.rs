//! What an improvement leaves as it is inside a mesh: facets with a tag, and those where volumes meet.

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use super::{ImproveReport, improve};
use crate::topology::TET_FACETS;
use crate::{Tags, TetMesh, facet_key};

/// Facets inside a mesh that stay, and its volumes.
#[derive(Clone)]
pub(super) struct Inside {
    /// Each facet with its tag; none where volumes meet without one.
    pub facets: BTreeMap<[usize; 3], Option<u32>>,
    /// For each tetrahedron the index of its volume; 0 for all where a mesh has no volumes.
    pub volumes: Vec<usize>,
}

impl Inside {
    /// Nothing stays.
    pub fn nothing(mesh: &TetMesh) -> Self {
        Self { facets: BTreeMap::new(), volumes: vec![0; mesh.tets.len()] }
    }

    /// Facets of two tetrahedra that have a tag or lie between volumes.
    pub fn tagged(mesh: &TetMesh, tags: &Tags) -> Self {
        let mut inside = Self::nothing(mesh);
        if !tags.volumes.of.is_empty() {
            inside.volumes.clone_from(&tags.volumes.of);
        }
        let of_tet = |(t, tet): (usize, &[usize; 4])| {
            TET_FACETS.map(|facet| (facet_key(facet.map(|c| tet[c])), t))
        };
        let mut all: Vec<_> = mesh.tets.iter().enumerate().flat_map(of_tet).collect();
        all.sort_unstable();
        for pair in all.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let [(facet, one), (_, other)] = [pair[0], pair[1]];
            let tag = tags.get(facet);
            if tag.is_some() || inside.volumes[one] != inside.volumes[other] {
                inside.facets.insert(facet, tag);
            }
        }
        inside
    }
}

/// [`super::improve_interior`], with some facets inside that stay as they are, bit for bit. Their
/// vertices and those of the boundary keep their numbers.
pub fn improve_around(
    mesh: &mut TetMesh,
    facets: &BTreeSet<[usize; 3]>,
    passes: usize,
) -> ImproveReport {
    let mut inside = Inside::nothing(mesh);
    inside.facets = facets.iter().map(|&facet| (facet, None)).collect();
    improve(mesh, &mut inside, passes)
}

/// [`super::improve_interior`] of a mesh with volumes, or with tags on facets inside. These facets, and those
/// where volumes meet, stay as they are, bit for bit; their vertices and those of the boundary keep
/// their numbers, so that `tags.facets` stays valid. `tags.volumes` follows the tetrahedra; those of
/// each volume follow each other from now on.
pub fn improve_tagged(mesh: &mut TetMesh, tags: &mut Tags, passes: usize) -> ImproveReport {
    let mut inside = Inside::tagged(mesh, tags);
    let report = improve(mesh, &mut inside, passes);
    if !tags.volumes.names.is_empty() {
        tags.volumes.of = inside.volumes;
    }
    report
}
