#![allow(clippy::unwrap_used)]

use super::shape::{energy, shape};
use super::*;
use crate::measure::volume;
use crate::topology::{TET_FACETS, boundary, tet_edges, vertex_neighbours};
use crate::{Vec3, facet_key};
use nalgebra::{Matrix3, matrix};
use std::collections::BTreeMap;

/// A box of ±30 mm with a ball of 15 mm cut out of it: `n` × `n` squares on each
/// side of the box, joined to the ball by `layers` layers of prisms, each of three
/// tetrahedra. The vertices of the ball come first, then those of the box.
pub(super) fn hollow_box(n: usize, layers: usize) -> (TetMesh, usize) {
    let (points, triangles) = cube_surface(n);
    let mut mesh = TetMesh::default();
    // From the ball outward the layers have the numbers 0, 2, 3, ..., 1.
    let number = |layer: usize| match layer {
        0 => 0,
        _ if layer == layers => 1,
        _ => layer + 1,
    };
    for depth in [0, layers].into_iter().chain(1..layers) {
        let s = depth as f64 / layers as f64;
        mesh.vertices
            .extend(points.iter().map(|p| p * 0.03 * s + p.normalize() * 0.015 * (1.0 - s)));
    }
    for layer in 0..layers {
        let [inner, outer] = [layer, layer + 1].map(|l| number(l) * points.len());
        for &triangle in &triangles {
            // Cutting from low to high numbers makes neighbours agree.
            let [a, b, c] = facet_key(triangle);
            for tet in [
                [inner + a, inner + b, inner + c, outer + c],
                [inner + a, inner + b, outer + b, outer + c],
                [inner + a, outer + a, outer + b, outer + c],
            ] {
                mesh.tets.push(tet);
            }
        }
    }
    mesh.turn_inverted();
    (mesh, points.len())
}

/// The surface of the cube [−1, 1]³.
fn cube_surface(n: usize) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let mut number = BTreeMap::new();
    let mut points = Vec::new();
    let mut vertex = |p: [usize; 3]| {
        *number.entry(p).or_insert_with(|| {
            points.push(Vec3::from(p.map(|i| 2.0 * i as f64 / n as f64 - 1.0)));
            points.len() - 1
        })
    };
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for cell in 0..n * n {
                let corner = |du: usize, dv: usize| {
                    let mut p = [side; 3];
                    p[(axis + 1) % 3] = cell % n + du;
                    p[(axis + 2) % 3] = cell / n + dv;
                    p
                };
                let [a, b, c, d] =
                    [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(u, v)| vertex(corner(u, v)));
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    (points, triangles)
}

/// Displaces the first `cavity` vertices by `map` − 1 about the origin, the box not
/// at all, and the interior by the average of its neighbours.
pub(super) fn deform(mesh: &mut TetMesh, cavity: usize, map: &Matrix3<f64>) {
    let count = mesh.vertices.len();
    let mut fixed = vec![false; count];
    boundary(mesh).facets.iter().flatten().for_each(|&v| fixed[v] = true);
    let mut shift = vec![Vec3::zeros(); count];
    for (s, x) in shift.iter_mut().zip(&mesh.vertices).take(cavity) {
        *s = map * x - x;
    }
    let neighbours = vertex_neighbours(count, &tet_edges(&mesh.tets));
    for _ in 0..200 {
        for v in (0..count).filter(|&v| !fixed[v]) {
            let sum: Vec3 = neighbours[v].iter().map(|&w| shift[w]).sum();
            shift[v] = sum / neighbours[v].len() as f64;
        }
    }
    for (x, s) in mesh.vertices.iter_mut().zip(&shift) {
        *x += s;
    }
}

/// Checks all that an improvement promises and returns its report.
fn improve_and_check(mesh: &mut TetMesh) -> ImproveReport {
    let (old, old_facets) = (mesh.clone(), boundary(mesh).facets);
    let report = improve_interior(mesh, 12);
    assert_eq!(boundary(mesh).facets, old_facets);
    for &v in old_facets.iter().flatten() {
        let bits = |m: &TetMesh| m.vertices[v].map(f64::to_bits);
        assert_eq!(bits(mesh), bits(&old));
    }
    // Sums of 10⁴ to 10⁵ terms: rounding stays below 1e-12.
    assert!((volume(mesh) / volume(&old) - 1.0).abs() < 1e-12);
    let mut owners = BTreeMap::new();
    let mut used = vec![false; mesh.vertices.len()];
    for tet in &mesh.tets {
        tet.iter().for_each(|&v| used[v] = true);
        for facet in TET_FACETS {
            *owners.entry(facet_key(facet.map(|k| tet[k]))).or_insert(0) += 1;
        }
    }
    assert!(owners.values().all(|&n| n <= 2), "a facet with three tetrahedra");
    assert!(used.iter().all(|&u| u), "a vertex without tetrahedra");
    assert_eq!(report.after, quality(mesh));
    assert_eq!(mesh.vertices.len() + report.removed, old.vertices.len() + report.added);
    report
}

#[test]
fn a_cavity_that_moved_far_gets_good_tetrahedra_again() {
    // 65 % longer, 35 % thinner and sheared.
    let map = matrix![1.65, 0.5, 0.0; 0.0, 0.65, 0.0; 0.3, 0.0, 0.65];
    let (mut mesh, cavity) = hollow_box(8, 6);
    deform(&mut mesh, cavity, &map);
    let report = improve_and_check(&mut mesh);
    // Mean ratio of the worst boundary triangle: 0.25.
    assert!(report.before.radius_ratio_min < 0.05, "{:?}", report.before);
    assert!(report.after.radius_ratio_min > 0.1, "{:?}", report.after);
    assert!(report.after.radius_ratio_p1 > 0.3, "{:?}", report.after);
    assert!(report.after.min_dihedral > 10.0, "{:?}", report.after);
}

#[test]
fn inverted_tetrahedra_are_turned_right() {
    let (mut mesh, cavity) = hollow_box(8, 6);
    deform(&mut mesh, cavity, &Matrix3::from_diagonal(&Vec3::new(1.2, 1.1, 1.2)));
    // Interior vertices thrown to the wrong side of their neighbours.
    for v in (cavity..5 * cavity).step_by(7) {
        mesh.vertices[v] *= 0.75;
    }
    let report = improve_and_check(&mut mesh);
    assert!(report.before.radius_ratio_min < -0.1, "{:?}", report.before);
    assert!(report.after.radius_ratio_min > 0.15, "{:?}", report.after);
}

#[test]
fn boundary_vertices_keep_their_numbers_even_the_highest() {
    let (mut mesh, cavity) = hollow_box(8, 6);
    deform(&mut mesh, cavity, &matrix![1.65, 0.5, 0.0; 0.0, 0.65, 0.0; 0.3, 0.0, 0.65]);
    let last = mesh.vertices.len() - 1;
    mesh.vertices.reverse();
    for tet in &mut mesh.tets {
        *tet = tet.map(|v| last - v);
    }
    let report = improve_and_check(&mut mesh);
    // No number is free: a vertex can be removed only for one that was added.
    assert!(report.removed > 0 && report.removed <= report.added, "{report:?}");
    assert!(report.after.radius_ratio_min > 0.1, "{:?}", report.after);
}

#[test]
fn edges_are_removed_whatever_the_size_of_their_ring() {
    for n in 3..=8 {
        // An edge so close to a vertex of its ring that those two tetrahedra are thin.
        let mut vertices = vec![Vec3::new(0.95, 0.0, -1.0), Vec3::new(0.95, 0.0, 1.0)];
        let angle = |i: usize| i as f64 * std::f64::consts::TAU / n as f64;
        vertices.extend((0..n).map(|i| Vec3::new(angle(i).cos(), angle(i).sin(), 0.0)));
        let tets = (0..n).map(|i| [0, 1, 2 + i, 2 + (i + 1) % n]).collect();
        let mut mesh = TetMesh { vertices, tets };
        let worst = |mesh: &TetMesh| {
            (0..mesh.tets.len()).map(|t| shape(mesh.corners(t))).fold(f64::INFINITY, f64::min)
        };
        let (old_worst, old_volume) = (worst(&mesh), volume(&mesh));
        let mut complex = Complex::new(&mesh, &Inside::nothing(&mesh));
        assert!(flip::flip(&mut complex, 1.0, 0) > 0, "{n}");
        (mesh, _) = complex.into_mesh();
        assert!(worst(&mesh) > old_worst);
        // No tetrahedron has both ends of the edge any more.
        assert!(!mesh.tets.iter().any(|tet| tet.contains(&0) && tet.contains(&1)));
        assert_eq!(mesh.tets.len(), 2 * (n - 2));
        assert!((volume(&mesh) / old_volume - 1.0).abs() < 1e-14);
    }
}

#[test]
fn shape_is_the_cubed_mean_ratio() {
    let corners = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]];
    let [a, b, c, d] = corners.map(|p| Vec3::from(p) * 1e-3);
    assert!((shape([a, b, c, d]) - 1.0).abs() < 1e-15);
    assert!((shape([b, a, c, d]) + 1.0).abs() < 1e-15);
    // Corner of a cube: V = 1/6, S = 9, η = 12 (1/2)^⅔ / 9.
    let corner = shape([Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]);
    let ratio: f64 = 12.0 * 0.5_f64.powf(2.0 / 3.0) / 9.0;
    assert!((corner - ratio.powi(3)).abs() < 1e-15);
}

#[test]
fn energy_derivatives_match_differences() {
    let link = [
        [Vec3::new(0.1, 0.0, 0.0), Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.0, 1.2, 0.1)],
        [Vec3::new(0.0, 1.2, 0.1), Vec3::new(1.0, 0.1, 0.0), Vec3::new(1.0, 1.0, 1.5)],
    ];
    // The second triangle is seen from behind: its tetrahedron is inverted.
    for (link, slack) in [(&link[..1], 0.0), (&link[..], 0.3)] {
        let x = Vec3::new(0.3, 0.4, 0.7);
        let at = |x: Vec3| energy(link, &x, slack).unwrap();
        let exact = at(x);
        let h = 1e-5;
        for k in 0..3 {
            let step = Vec3::ith(k, h);
            let (plus, minus) = (at(x + step), at(x - step));
            let slope = (plus.value - minus.value) / (2.0 * h);
            // Central differences: h² ~ 1e-10 times third derivatives, of the order
            // of p³ ~ 500 per length³.
            assert!((slope / exact.gradient[k] - 1.0).abs() < 1e-6, "{slope}");
            if slack == 0.0 {
                let column = (plus.gradient - minus.gradient) / (2.0 * h);
                let error = (column - exact.hessian.column(k)).norm() / column.norm();
                assert!(error < 1e-6, "{error}");
            }
        }
    }
    assert!(energy(&link, &Vec3::new(0.1, 0.0, -1.0), 0.0).is_none());
}
