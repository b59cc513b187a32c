#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, matrix};

use super::super::tests::{deform, hollow_box};
use super::super::{improve_around, improve_tagged, improve_with_surface, usual_tolerance};
use crate::measure::{quality, tet_volume, triangle_area};
use crate::topology::{TET_FACETS, boundary};
use crate::{Tags, TetMesh, Volumes, facet_key};

/// A hollow box whose ball, with the tags `upper` and `lower`, has been stretched by a map, of two volumes. They
/// meet two layers from the ball, in facets of which the upper half has the tag `paper`.
fn two_volumes(layers: usize, map: &Matrix3<f64>) -> (TetMesh, Tags) {
    let (mut mesh, count) = hollow_box(8, layers);
    // numbers of layers from the ball outward: 0, 2, 3, ..., 1
    let is_inner =
        |tet: &[usize; 4]| tet.iter().all(|v| *v < count || (2..4).contains(&(v / count)));
    let mut tags = Tags::new(vec!["paper".into(), "upper".into(), "lower".into()]);
    let of = mesh.tets.iter().map(|tet| usize::from(!is_inner(tet))).collect();
    tags.volumes = Volumes { names: vec!["inner".into(), "outer".into()], of };
    for facet in boundary(&mesh).facets {
        if facet.iter().all(|&v| v < count) {
            let above = facet.iter().map(|&v| mesh.vertices[v].z).sum::<f64>() > 0.0;
            tags.set(facet, if above { 2 } else { 3 });
        }
    }
    for facet in between(&mesh, &tags) {
        if facet.iter().all(|&v| mesh.vertices[v].z > 0.0) {
            tags.set(facet, 1);
        }
    }
    deform(&mut mesh, count, map);
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

/// Measure of each volume [m³], and area of each tag [m²].
fn measures(mesh: &TetMesh, tags: &Tags) -> ([f64; 2], [f64; 3]) {
    let (mut volumes, mut areas) = ([0.0; 2], [0.0; 3]);
    for (t, &volume) in tags.volumes.of.iter().enumerate() {
        let [a, b, c, d] = mesh.corners(t);
        volumes[volume] += tet_volume(a, b, c, d);
    }
    for (facet, id) in &tags.facets {
        let [a, b, c] = facet.map(|v| mesh.vertices[v]);
        areas[*id as usize - 1] += triangle_area(a, b, c);
    }
    (volumes, areas)
}

#[test]
fn volumes_and_the_facets_between_them_stay() {
    let map = matrix![1.5, 0.3, 0.0; 0.0, 0.75, 0.0; 0.0, 0.0, 0.75];
    let (mut mesh, mut tags) = two_volumes(5, &map);
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
    let ((volumes, areas), (old_volumes, old_areas)) =
        (measures(&mesh, &tags), measures(&old, &old_tags));
    for (new, old) in volumes.iter().zip(old_volumes).chain(areas.iter().zip(old_areas)) {
        // sums of some thousand terms
        assert!((new / old - 1.0).abs() < 1e-12, "{new} {old}");
    }
}

/// The cavity may change here, and with it the volume beside it; the other one and the layer may not.
#[test]
fn they_stay_where_the_surface_may_change() {
    let map = matrix![1.9, 0.0, 0.0; 0.0, 0.05, 0.0; 0.0, 0.0, 1.0];
    let (mut mesh, mut tags) = two_volumes(3, &map);
    let (old, old_tags) = (mesh.clone(), tags.clone());
    let mut alone = (mesh.clone(), tags.clone());
    improve_tagged(&mut alone.0, &mut alone.1, 10);
    let moving: Vec<[usize; 3]> =
        boundary(&mesh).facets.into_iter().filter(|&f| tags.get(f).is_some()).collect();
    let tolerance = usual_tolerance(&mesh.vertices, &moving);
    improve_with_surface(&mut mesh, &mut tags, &moving, tolerance, 10);
    let worst = |mesh: &TetMesh| quality(mesh).min_dihedral;
    assert!(worst(&mesh) >= worst(&alone.0), "{} {}", worst(&mesh), worst(&alone.0));
    let ((volumes, areas), (old_volumes, old_areas)) =
        (measures(&mesh, &tags), measures(&old, &old_tags));
    assert!((volumes[1] / old_volumes[1] - 1.0).abs() < 1e-12);
    assert!((areas[0] / old_areas[0] - 1.0).abs() < 1e-12);
    assert!((volumes[0] / old_volumes[0] - 1.0).abs() < 1e-2);
    let places = |mesh: &TetMesh, tags: &Tags| -> BTreeSet<[[u64; 3]; 3]> {
        let place = |v: usize| <[f64; 3]>::from(mesh.vertices[v]).map(f64::to_bits);
        let facets = between(mesh, tags).into_iter().chain(tags.facets_of(1));
        let sorted = |mut f: [[u64; 3]; 3]| {
            f.sort_unstable();
            f
        };
        facets.map(|facet| sorted(facet.map(place))).collect()
    };
    assert_eq!(places(&mesh, &tags), places(&old, &old_tags));
    let all: BTreeSet<[usize; 3]> = mesh.tets.iter().flat_map(keys).collect();
    assert!(tags.facets.keys().all(|facet| all.contains(facet)));
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
