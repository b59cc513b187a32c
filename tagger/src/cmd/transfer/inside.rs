//! What lies inside a tagged mesh: facets with a tag, and volumes.

use std::collections::BTreeMap;

use anyhow::{Result, bail, ensure};
use mesh::topology::TET_FACETS;
use mesh::{Tags, TetMesh, Vec3, Volumes, facet_key};

use super::bits;
use crate::select::point;

/// A vertex, by the bits of its position.
type Place = [u64; 3];

/// Facets that both meshes need to have, by the places of their corners.
pub struct Inside {
    /// Facets inside, the tag of each if it has one.
    facets: BTreeMap<[Place; 3], Option<u32>>,
    /// The volume behind each facet of those and of the boundary, whose corners are counter-clockwise
    /// from the other side, the least one first.
    behind: BTreeMap<[Place; 3], usize>,
    names: Vec<String>,
}

impl Inside {
    /// Facets of two tetrahedra that have a tag or lie between volumes.
    pub fn new(mesh: &TetMesh, tags: &Tags) -> Self {
        let volume = |t: usize| tags.volumes.of.get(t).copied().unwrap_or(0);
        let (mut facets, mut behind) = (BTreeMap::new(), BTreeMap::new());
        for (key, sides) in sides(mesh) {
            let tag = tags.get(key);
            let parted = sides.windows(2).any(|pair| volume(pair[0].0) != volume(pair[1].0));
            if sides.len() == 2 && (tag.is_some() || parted) {
                facets.insert(sorted(places(mesh, key)), tag);
            } else if sides.len() == 2 {
                continue;
            }
            for (t, facet) in sides {
                behind.insert(turned(places(mesh, facet)), volume(t));
            }
        }
        Self { facets, behind, names: tags.volumes.names.clone() }
    }

    /// Adds its facets and volumes to the tags of a mesh with the same boundary.
    pub fn transfer(&self, mesh: &TetMesh, tags: &mut Tags) -> Result<()> {
        let (mut found, mut open) = (0, Vec::new());
        for (key, sides) in sides(mesh) {
            let [one, other] = &sides[..] else { continue };
            match self.facets.get(&sorted(places(mesh, key))) {
                None => open.push([one.0, other.0]),
                Some(tag) => {
                    found += 1;
                    tag.iter().for_each(|&id| tags.set(key, id));
                }
            }
        }
        if found < self.facets.len() {
            bail!(
                "{} of {} facets inside, with a tag or between volumes, have no exact twin, one of them \
                 at {} m\n  they are carried only where both meshes have them: re-mesh with cad2fem remesh, \
                 which keeps them, or tag the new mesh from its selections: tagger tag",
                self.facets.len() - found,
                self.facets.len(),
                self.lost(mesh)
            );
        }
        if !self.names.is_empty() {
            tags.volumes = Volumes { names: self.names.clone(), of: self.volumes(mesh, &open)? };
        }
        Ok(())
    }

    /// Where a facet lies that a mesh does not have [m].
    fn lost(&self, mesh: &TetMesh) -> String {
        let known: std::collections::BTreeSet<[Place; 3]> =
            sides(mesh).into_keys().map(|key| sorted(places(mesh, key))).collect();
        let first = self.facets.keys().find(|facet| !known.contains(*facet));
        first.map_or_else(String::new, |facet| point(&Vec3::from(facet[0].map(f64::from_bits))))
    }

    /// The volume of each tetrahedron: that behind the facets which bound its part, whose
    /// tetrahedra meet in the facets `open`.
    fn volumes(&self, mesh: &TetMesh, open: &[[usize; 2]]) -> Result<Vec<usize>> {
        let mut near = vec![Vec::new(); mesh.tets.len()];
        for &[one, other] in open {
            near[one].push(other);
            near[other].push(one);
        }
        let mut of = vec![None; mesh.tets.len()];
        for (_, sides) in sides(mesh) {
            for (t, facet) in sides {
                if let Some(&volume) = self.behind.get(&turned(places(mesh, facet))) {
                    fill(&mut of, &near, t, volume)?;
                }
            }
        }
        let without = of.iter().filter(|volume| volume.is_none()).count();
        ensure!(without == 0, "{without} tetrahedra are behind no facet of the tagged mesh");
        Ok(of.into_iter().flatten().collect())
    }
}

/// Gives a tetrahedron and all that can be reached from it a volume.
fn fill(of: &mut [Option<usize>], near: &[Vec<usize>], start: usize, volume: usize) -> Result<()> {
    let mut stack = vec![start];
    while let Some(t) = stack.pop() {
        match of[t] {
            None => {
                of[t] = Some(volume);
                stack.extend(&near[t]);
            }
            Some(other) => ensure!(other == volume, "a part of the mesh is in two volumes"),
        }
    }
    Ok(())
}

/// The tetrahedra of each facet, with its corners counter-clockwise from outside of them.
fn sides(mesh: &TetMesh) -> BTreeMap<[usize; 3], Vec<(usize, [usize; 3])>> {
    let mut all: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for (t, tet) in mesh.tets.iter().enumerate() {
        for facet in TET_FACETS.map(|facet| facet.map(|c| tet[c])) {
            all.entry(facet_key(facet)).or_default().push((t, facet));
        }
    }
    all
}

fn places(mesh: &TetMesh, facet: [usize; 3]) -> [Place; 3] {
    facet.map(|v| bits(&mesh.vertices[v]))
}

fn sorted(mut places: [Place; 3]) -> [Place; 3] {
    places.sort_unstable();
    places
}

/// The facet seen from the same side, its least corner first.
fn turned(mut places: [Place; 3]) -> [Place; 3] {
    let least = (0..3).min_by_key(|&k| places[k]).unwrap_or(0);
    places.rotate_left(least);
    places
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A pyramid below a square and one above it, which is a sheet; both are volumes.
    fn layered() -> (TetMesh, Tags) {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)];
        let mut vertices: Vec<Vec3> = square.map(|(x, y)| Vec3::new(x, y, 1.0)).to_vec();
        vertices.extend([Vec3::new(1.0, 0.5, 3.0), Vec3::new(1.0, 0.5, 0.0)]);
        let tets = vec![[0, 1, 2, 4], [0, 2, 3, 4], [0, 2, 1, 5], [0, 3, 2, 5]];
        let mut tags = Tags::new(vec!["paper".into()]);
        tags.set([0, 1, 2], 1);
        tags.volumes =
            Volumes { names: vec!["above".into(), "below".into()], of: vec![0, 0, 1, 1] };
        (TetMesh { vertices, tets }, tags)
    }

    #[test]
    fn volumes_and_sheets_are_carried_to_other_numbers() {
        let (old, tags) = layered();
        let mut new = old.clone();
        new.vertices.reverse();
        new.tets.iter_mut().for_each(|tet| *tet = tet.map(|v| 5 - v));
        new.tets.reverse();
        let mut carried = Tags::new(tags.names.clone());
        Inside::new(&old, &tags).transfer(&new, &mut carried).unwrap();
        assert_eq!(carried.volumes.of, [1, 1, 0, 0]);
        assert_eq!(carried.volumes.names, tags.volumes.names);
        assert_eq!(carried.facets_of(1), [[3, 4, 5]]);
    }

    /// The other diagonal of the square: the boundary is the same, the sheet is not.
    #[test]
    fn a_sheet_that_is_not_there_is_told() {
        let (old, tags) = layered();
        let tets = vec![[0, 1, 3, 4], [1, 2, 3, 4], [0, 3, 1, 5], [1, 3, 2, 5]];
        let new = TetMesh { tets, ..old.clone() };
        let mut carried = Tags::new(tags.names.clone());
        let message = Inside::new(&old, &tags).transfer(&new, &mut carried).unwrap_err();
        assert!(message.to_string().contains("2 of 2 facets inside"), "{message}");
    }
}
