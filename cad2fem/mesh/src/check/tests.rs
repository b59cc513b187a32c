//! Every rule finds its fault, with numbers, and nothing in sound meshes.

use super::*;
use crate::TetMesh;
use crate::measure::enclosed_volume;
use crate::topology::TET_FACETS;

fn joined(parts: &[SurfaceMesh]) -> SurfaceMesh {
    let mut all = SurfaceMesh::default();
    parts.iter().for_each(|part| all.append(part));
    all
}

/// A tetrahedron with corners at `origin` and `size` along the axes.
fn corner(origin: [f64; 3], size: f64) -> SurfaceMesh {
    let origin = Vec3::from(origin);
    let tips = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    SurfaceMesh {
        vertices: tips.map(|tip| origin + size * tip).to_vec(),
        triangles: TET_FACETS.to_vec(),
    }
}

fn rules(surface: &SurfaceMesh) -> Vec<(&'static str, usize)> {
    check_surface(surface).iter().map(|finding| (finding.rule, finding.count)).collect()
}

#[test]
fn open_rims_are_measured() {
    let mut open = corner([0.0; 3], 1.0);
    open.triangles.remove(1);
    let findings = check_surface(&open);
    assert_eq!(rules(&open), [("closed", 3)]);
    // The facet x = 0 is missing: two legs and the diagonal, 2 + √2.
    assert!(findings[0].message.contains("3 edges in 1 rims"), "{}", findings[0].message);
    assert!(findings[0].message.contains("3.414214 m"), "{}", findings[0].message);
}

#[test]
fn sheets_that_touch_in_a_point_or_an_edge_are_found() {
    // The second tetrahedron hangs on the tip of the first.
    let mut pinched = joined(&[corner([0.0; 3], 1.0), corner([1.0, 0.0, 0.0], 1.0)]);
    pinched.triangles.iter_mut().flatten().filter(|v| **v == 4).for_each(|v| *v = 1);
    assert_eq!(rules(&pinched), [("manifold", 1)]);
    assert!(check_surface(&pinched)[0].message.contains("vertex 1 at (1.000000, 0.000000"));
    // Two tetrahedra on one edge: four triangles there.
    let mut book = joined(&[corner([0.0; 3], 1.0), corner([0.0; 3], 1.0)]);
    book.vertices[6] = -Vec3::y();
    book.vertices[7] = -Vec3::z();
    book.triangles.iter_mut().flatten().for_each(|v| *v = if *v == 4 { 0 } else { *v });
    book.triangles.iter_mut().flatten().for_each(|v| *v = if *v == 5 { 1 } else { *v });
    let found = run(&book, &["manifold"]);
    assert!(found[0].message.contains("first edge 0-1 with 4 at (0.500000"), "{found:?}");
}

#[test]
fn wrong_winding_is_found() {
    let mut flipped = corner([0.0; 3], 1.0);
    flipped.triangles[2].swap(0, 1);
    assert_eq!(rules(&flipped), [("oriented", 3)]);
    let mut inward = corner([0.0; 3], 1.0);
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_eq!(rules(&inward), [("oriented", 1)]);
    assert!(check_surface(&inward)[0].message.contains("-1.666667e-1 m³"));
}

#[test]
fn flat_triangles_are_found_at_any_scale() {
    for scale in [1e-6, 1.0, 1e6] {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1e-14, 0.0], [0.5, 1e-9, 0.0]];
        let surface = SurfaceMesh {
            vertices: points.map(|p| scale * Vec3::from(p)).to_vec(),
            triangles: vec![[0, 1, 3], [0, 1, 2], [0, 0, 1]],
        };
        let found = run(&surface, &["degenerate"]);
        assert_eq!(found[0].count, 2);
        assert!(found[0].message.contains("2 of 3") && found[0].message.contains("triangle 1"));
    }
}

#[test]
fn shells_that_pierce_each_other_are_found() {
    let pair = joined(&[corner([0.0; 3], 1.0), corner([0.2, 0.2, -0.1], 1.0)]);
    let found = check_surface(&pair);
    assert_eq!(found.len(), 1);
    assert_eq!(
        (found[0].rule, found[0].count),
        ("intersecting", crate::crossings::self_intersecting_pairs(&pair).len())
    );
    assert!(found[0].count > 0);
}

#[test]
fn unusable_numbers_end_the_check() {
    let mut broken = corner([0.0; 3], 1.0);
    broken.vertices[3].z = f64::INFINITY;
    broken.triangles[1][0] = 9;
    let found = check_surface(&broken);
    assert_eq!(found.len(), 2);
    assert!(found[0].message.contains("vertex 3 at (0.000000, 0.000000, inf)"), "{found:?}");
    assert!(found[1].message.contains("triangle 1"), "{found:?}");
    assert_eq!(rules(&SurfaceMesh::default()), [("finite", 1)]);
}

#[test]
fn nested_shells_face_outward_and_inward_by_turns() {
    // From outside in, deliberately with mixed winding, and one shell beside them.
    let sizes = [1.0, 0.7, 0.4, 0.1];
    let nested = sizes.map(|size| corner([(1.0 - size) / 5.0; 3], size));
    let mut solid = joined(&nested);
    solid = joined(&[solid, corner([2.0, 0.0, 0.0], 1.0)]);
    for t in [0, 4, 5, 6, 7, 9, 17] {
        solid.triangles[t].swap(0, 1);
    }
    orient_by_nesting(&mut solid);
    let cubes = |s: f64| s.powi(3) / 6.0;
    let known = cubes(1.0) - cubes(0.7) + cubes(0.4) - cubes(0.1) + cubes(1.0);
    assert!((enclosed_volume(&solid) - known).abs() < 1e-14);
    assert_eq!(check_surface(&solid), []);
}

#[test]
fn faults_of_tetrahedra_are_found() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
    let sound = TetMesh {
        vertices: points.map(Vec3::from).to_vec(),
        tets: vec![[0, 1, 2, 3], [1, 4, 2, 3]],
    };
    assert_eq!(check_tets(&sound), []);
    let found = |damage: fn(&mut TetMesh)| {
        let mut mesh = sound.clone();
        damage(&mut mesh);
        let found = check_tets(&mesh);
        found.iter().map(|f| (f.rule, f.count)).collect::<Vec<_>>()
    };
    assert_eq!(found(|m| m.vertices[4].x = f64::NAN), [("finite", 1)]);
    assert_eq!(found(|m| m.tets[1][1] = 5), [("indices", 1)]);
    assert_eq!(found(|m| m.tets.clear()), [("indices", 1)]);
    // Upside down it also lies on the wrong side of the common facet.
    assert_eq!(found(|m| m.tets[1].swap(2, 3)), [("volume", 1), ("conforming", 1)]);
    // It overlaps the first at facet 0-1-2 and the second at 1-2-4.
    assert_eq!(found(|m| m.tets.push([0, 1, 2, 4])), [("conforming", 2)]);
    assert_eq!(found(|m| m.tets.truncate(1)), [("unused", 1)]);
}

/// Two tetrahedra on a common facet, and a third on one of them with a tip at the corner of the first.
fn doubled(off: f64, joined: bool) -> TetMesh {
    let tip = Vec3::x() * (1.0 + off);
    let mut vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::z(), tip];
    let base = if joined { [0, 2, 4] } else { [6, 7, 8] };
    vertices.extend([-Vec3::x(), -Vec3::y(), -Vec3::z()].map(|v| v * 2.0));
    let third = [base[0], base[1], base[2], 5];
    TetMesh { vertices, tets: vec![[0, 1, 2, 3], [0, 2, 1, 4], third] }
}

#[test]
fn vertices_at_one_place_are_found_in_a_body_but_not_between_bodies() {
    let found = coincident(&doubled(0.0, true)).expect("they are at one place");
    assert_eq!((found.rule, found.count), ("coincident", 1));
    assert!(found.message.contains("first 1 and 5, 0.0e0 m apart, at (1.0"), "{}", found.message);
    assert!(coincident(&doubled(1e-6, true)).is_some());
    assert_eq!(coincident(&doubled(1e-4, true)), None);
    assert_eq!(coincident(&doubled(0.0, false)), None);
}
