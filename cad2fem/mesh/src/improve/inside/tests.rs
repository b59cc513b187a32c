#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::matrix;

use super::super::tests::{deform, hollow_box};
use super::super::{improve_around, improve_tagged};
use crate::topology::TET_FACETS;
use crate::{Tags, TetMesh, Volumes, facet_key};

/// A hollow box, stretched, of two volumes. They meet two layers from the ball, in facets of which the upper half
/// has a tag.
fn two_volumes() -> (TetMesh, Tags) {
    let (mut mesh, count) = hollow_box(8, 5);
    // numbers of layers from the ball outward: 0, 2, 3, ..., 1
    let is_inner =
        |tet: &[usize; 4]| tet.iter().all(|v| *v < count || (2..4).contains(&(v / count)));
    let mut tags = Tags::new(vec!["paper".into()]);
    let of = mesh.tets.iter().map(|tet| usize::from(!is_inner(tet))).collect();
    tags.volumes = Volumes { names: vec!["inner".into(), "outer".into()], of };
    for facet in between(&mesh, &tags) {
        if facet.iter().all(|&v| mesh.vertices[v].z > 0.0) {
            tags.set(facet, 1);
        }
    }
    deform(&mut mesh, count, &matrix![1.5, 0.3, 0.0; 0.0, 0.75, 0.0; 0.0, 0.0, 0.75]);
    (mesh, tags)
}

fn keys(tet: &[usize; 4]) -> [[usize; 3]; 4] {
    TET_FACETS.map(|f| facet_key(f.map(|c| tet[c])))
}

/// The facets where volumes meet.
fn between(mesh: &TetMesh, tags: &Tags) -> BTreeSet<[usize; 3]> {
    let mut first = BTreeMap::new();
    let mut found = BTreeSet::new();
    for (tet, volume) in mesh.tets.iter().zip(&tags.volumes.of) {
        for key in keys(tet) {
            if first.insert(key, *volume).is_some_and(|other| other != *volume) {
                found.insert(key);
            }
        }
    }
    found
}

/// Measure of each volume [m³].
fn measures(mesh: &TetMesh, tags: &Tags) -> [f64; 2] {
    let mut volumes = [0.0; 2];
    tags.volumes.of.iter().enumerate().for_each(|(t, &volume)| volumes[volume] += mesh.volume(t));
    volumes
}

#[test]
fn volumes_and_the_facets_between_them_stay() {
    let (mut mesh, mut tags) = two_volumes();
    let (old, old_tags) = (mesh.clone(), tags.clone());
    let report = improve_tagged(&mut mesh, &mut tags, 10);
    assert!(report.flips > 0 && report.moved > 0, "{report:?}");
    assert!(report.after.radius_ratio_min > 1.5 * report.before.radius_ratio_min, "{report:?}");
    assert_eq!(tags.facets, old_tags.facets);
    assert_eq!(tags.volumes.names, old_tags.volumes.names);
    assert_eq!(between(&mesh, &tags), between(&old, &old_tags));
    let stay: BTreeSet<usize> = between(&old, &old_tags).into_iter().flatten().collect();
    assert!(stay.iter().all(|&v| mesh.vertices[v] == old.vertices[v]));
    assert!(tags.volumes.of.is_sorted() && tags.volumes.of.len() == mesh.tets.len());
    for (new, old) in measures(&mesh, &tags).iter().zip(measures(&old, &old_tags)) {
        // sums of some thousand terms
        assert!((new / old - 1.0).abs() < 1e-12, "{new} {old}");
    }
}

/// All corners of a strip are on its rim, so that both its sides have the same vertices.
#[test]
fn a_narrow_strip_inside_stays() {
    let (mut mesh, count) = hollow_box(8, 5);
    let layer = |v: &usize| (3 * count..4 * count).contains(v);
    let inner: BTreeSet<[usize; 3]> =
        mesh.tets.iter().flat_map(keys).filter(|f| f.iter().all(layer)).collect();
    // each facet without a neighbour that was taken before it
    let mut strips = BTreeSet::new();
    let mut used = BTreeSet::new();
    for facet in inner {
        if facet.iter().all(|v| !used.contains(v)) {
            used.extend(facet);
            strips.insert(facet);
        }
    }
    assert!(strips.len() > 20);
    deform(&mut mesh, count, &matrix![1.6, 0.5, 0.0; 0.0, 0.65, 0.0; 0.3, 0.0, 0.65]);
    let old = mesh.clone();
    let report = improve_around(&mut mesh, &strips, 10);
    assert!(report.flips > 0, "{report:?}");
    let after: BTreeSet<[usize; 3]> = mesh.tets.iter().flat_map(keys).collect();
    assert!(strips.is_subset(&after));
    assert!(used.iter().all(|&v| mesh.vertices[v] == old.vertices[v]));
}
