#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use nalgebra::matrix;

use super::*;
use crate::improve::improve_interior;
use crate::improve::tests::{deform, hollow_box};
use crate::measure::{mean_edge, triangle_area, volume};
use crate::topology::TET_FACETS;
use crate::{Vec3, Volumes};

/// Tags the cavity of a hollow box, whose vertices are the first `count`: 1 where z > 0, 2
/// elsewhere. Its facets.
fn tag_cavity(mesh: &TetMesh, count: usize) -> (Tags, Vec<[usize; 3]>) {
    let mut tags = Tags::new(vec!["upper".into(), "lower".into()]);
    let inner = |f: &[usize; 3]| f.iter().all(|&v| v < count);
    let facets: Vec<[usize; 3]> = boundary(mesh).facets.into_iter().filter(inner).collect();
    for &facet in &facets {
        let upper = facet.iter().all(|&v| mesh.vertices[v].z > -1e-9);
        tags.set(facet, if upper { 1 } else { 2 });
    }
    (tags, facets)
}

fn area_of(mesh: &TetMesh, tags: &Tags, id: u32) -> f64 {
    let area = |facet: [usize; 3]| {
        let [a, b, c] = facet.map(|v| mesh.vertices[v]);
        triangle_area(a, b, c)
    };
    tags.facets_of(id).into_iter().map(area).sum()
}

/// Places of the vertices that facets of both tags, or a tag and no tag, have in common.
fn rim(mesh: &TetMesh, tags: &Tags) -> BTreeSet<[u64; 3]> {
    let mut seen: BTreeMap<usize, BTreeSet<Option<u32>>> = BTreeMap::new();
    for facet in boundary(mesh).facets {
        for v in facet {
            seen.entry(v).or_default().insert(tags.get(facet));
        }
    }
    let several = seen.into_iter().filter(|(_, tags)| tags.len() > 1);
    several.map(|(v, _)| place(&mesh.vertices[v])).collect()
}

fn place(p: &Vec3) -> [u64; 3] {
    [p.x, p.y, p.z].map(f64::to_bits)
}

/// Facets by the places of their corners.
fn places(mesh: &TetMesh, facets: impl IntoIterator<Item = [usize; 3]>) -> BTreeSet<[[u64; 3]; 3]> {
    let key = |facet: [usize; 3]| {
        let mut places = facet.map(|v| place(&mesh.vertices[v]));
        places.sort_unstable();
        places
    };
    facets.into_iter().map(key).collect()
}

/// The facets of the boundary without a tag.
fn untouched(mesh: &TetMesh, tags: &Tags) -> BTreeSet<[[u64; 3]; 3]> {
    places(mesh, boundary(mesh).facets.into_iter().filter(|&f| tags.get(f).is_none()))
}

/// A tetrahedron that lies on the boundary like a scale, with four vertices there: it closes a
/// shallow valley along the edge between two facets of the box's top.
#[test]
fn a_flat_tetrahedron_on_the_surface_is_taken_off() {
    let (mut mesh, count) = hollow_box(4, 2);
    let on_top = |f: &[usize; 3]| f.iter().all(|&v| (mesh.vertices[v].z - 0.03).abs() < 1e-9);
    let top: Vec<[usize; 3]> = boundary(&mesh).facets.into_iter().filter(on_top).collect();
    let inner = |v: usize| mesh.vertices[v].xy().amax() < 0.02;
    let both = top.iter().filter(|f| f.iter().all(|&v| inner(v)));
    let both: Vec<[usize; 3]> = both.copied().take(2).collect();
    let ends: Vec<usize> = both[0].into_iter().filter(|v| both[1].contains(v)).collect();
    let other = |f: [usize; 3]| f.into_iter().find(|v| !ends.contains(v)).unwrap();
    let [a, b, c, d] = [ends[0], ends[1], other(both[0]), other(both[1])];
    for v in [a, b] {
        mesh.vertices[v].z -= 2e-4;
    }
    let mut scale = [a, b, c, d];
    if shape_of(&mesh, scale) < 0.0 {
        scale.swap(0, 1);
    }
    mesh.tets.push(scale);
    assert!(shape_of(&mesh, scale) < POOR);
    let mut tags = Tags::new(vec!["top".into(), "sheet".into()]);
    // two volumes with a sheet between them, half-way to the ball
    let of = mesh.tets.iter().map(|tet| usize::from(tet.iter().all(|&v| v >= count))).collect();
    tags.volumes = Volumes { names: vec!["inner".into(), "outer".into()], of };
    for facet in mesh.tets.iter().flat_map(|tet| TET_FACETS.map(|f| f.map(|c| tet[c]))) {
        if facet.iter().all(|&v| v >= 2 * count) {
            tags.set(facet, 2);
        }
    }
    let sheet = sheet_of(&mesh, &tags);
    let replaced = |f: &&[usize; 3]| !both.contains(f);
    for facet in top.iter().filter(replaced).chain(&[[a, c, d], [b, c, d]]) {
        tags.set(*facet, 1);
    }
    let moving: Vec<[usize; 3]> =
        boundary(&mesh).facets.into_iter().filter(|&f| tags.get(f) == Some(1)).collect();
    assert_eq!(moving.len(), top.len());
    let alone = improve_interior(&mut mesh.clone(), 0);
    let (interior, report) = improve_with_surface(&mut mesh, &mut tags, &moving, 3e-4, 0);
    assert_eq!((report.flips, report.collapses, report.splits, report.moved), (1, 0, 0, 0));
    assert!(report.distance > 1e-4 && report.distance < 2e-4, "{report:?}");
    assert!(!mesh.tets.iter().any(|tet| scale.iter().all(|v| tet.contains(v))));
    assert!(interior.after.radius_ratio_min > 2.0 * alone.after.radius_ratio_min, "{interior:?}");
    assert_eq!(sheet_of(&mesh, &tags), sheet);
    let inner = |tet: &[usize; 4]| tet.iter().any(|&v| mesh.vertices[v].norm() < 0.0151);
    let of: Vec<usize> = mesh.tets.iter().map(|tet| usize::from(!inner(tet))).collect();
    assert_eq!(tags.volumes.of, of);
}

/// The facets inside with the second tag.
fn sheet_of(mesh: &TetMesh, tags: &Tags) -> BTreeSet<[[u64; 3]; 3]> {
    let all = mesh.tets.iter().flat_map(|tet| TET_FACETS.map(|f| f.map(|c| tet[c])));
    places(mesh, all.filter(|&facet| tags.get(facet) == Some(2)))
}

fn shape_of(mesh: &TetMesh, tet: [usize; 4]) -> f64 {
    crate::improve::shape::shape(tet.map(|v| mesh.vertices[v]))
}

/// A cavity that a design has stretched to twice its length and a twentieth of its width.
#[test]
fn a_stretched_surface_gets_better_within_its_tolerance_and_tags_rims_and_the_rest_stay() {
    let (mut mesh, count) = hollow_box(8, 3);
    let (mut tags, moving) = tag_cavity(&mesh, count);
    deform(&mut mesh, count, &matrix![1.9, 0.0, 0.0; 0.0, 0.05, 0.0; 0.0, 0.0, 1.0]);
    let mut alone = mesh.clone();
    improve_interior(&mut alone, 10);
    let (before, old_tags) = (mesh.clone(), tags.clone());
    let tolerance = 0.05 * mean_edge(&mesh.vertices, &moving);
    let (interior, report) = improve_with_surface(&mut mesh, &mut tags, &moving, tolerance, 10);
    assert!(report.changed() && report.distance <= tolerance, "{report:?}");
    let worst = |mesh: &TetMesh| {
        mesh.tets.iter().map(|&tet| shape_of(mesh, tet)).fold(f64::INFINITY, f64::min)
    };
    let (one, both) = (worst(&alone), worst(&mesh));
    assert!(both > 1.5 * one, "{one} {both}");
    assert!(interior.after.min_dihedral > quality(&alone).min_dihedral);
    assert_eq!(rim(&mesh, &tags), rim(&before, &old_tags));
    assert_eq!(untouched(&mesh, &tags), untouched(&before, &old_tags));
    for id in [1, 2] {
        let areas = area_of(&mesh, &tags, id) / area_of(&before, &old_tags, id);
        assert!((areas - 1.0).abs() < 0.02, "{areas}");
    }
    assert!((volume(&mesh) / volume(&before) - 1.0).abs() < 2e-3);
    let tagged = tags
        .facets
        .keys()
        .filter(|key| boundary(&mesh).facets.iter().any(|f| facet_key(*f) == **key));
    assert_eq!(tagged.count(), tags.facets.len(), "tags are facets of the boundary");
}

#[test]
fn a_good_surface_keeps_its_bits() {
    let (mut mesh, count) = hollow_box(6, 3);
    let (mut tags, moving) = tag_cavity(&mesh, count);
    let mut alone = mesh.clone();
    improve_interior(&mut alone, 10);
    let old_tags = tags.clone();
    let (_, report) = improve_with_surface(&mut mesh, &mut tags, &moving, 1e-3, 10);
    assert_eq!(report, SurfaceReport::default());
    assert_eq!((mesh, tags), (alone, old_tags));
}
