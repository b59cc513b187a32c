#![allow(clippy::unwrap_used)]

use super::*;
use std::f64::consts::PI;

fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs()
}

fn cube(x0: f64, x1: f64) -> Solid {
    Solid::cube(&Vec3::repeat(x0), &Vec3::repeat(x1))
}

#[test]
fn booleans_of_boxes_in_metres_are_exact_to_rounding() {
    // 70 mm and 5 mm boxes overlapping by 1 mm³: the sizes of an actuator.
    let (a, b) = (cube(0.0, 0.07), cube(0.069, 0.074));
    let (va, vb, both) = (0.07_f64.powi(3), 0.005_f64.powi(3), 1e-9);
    for (volume, expected) in [
        (a.union(&b).volume(), va + vb - both),
        (a.difference(&b).volume(), va - both),
        // 1 mm is 0.07 − 0.069: its rounding alone is 1e-14.
        (a.intersection(&b).volume(), both),
    ] {
        assert!(relative(volume, expected) < 1e-12, "{volume} {expected}");
    }
    assert!(a.intersection(&cube(0.08, 0.09)).is_empty());
    assert!(relative(a.area(), 6.0 * 0.07 * 0.07) < 1e-14);
}

#[test]
fn box_corners_are_exact() {
    let (min, max) = (Vec3::new(-0.1, 0.3, 0.7), Vec3::new(0.2, 0.9, 0.8));
    let solid = Solid::cube(&min, &max);
    assert_eq!(solid.bounds(), (min, max));
    assert_eq!(solid.to_surface().triangles.len(), 12);
    assert!(Solid::cube(&max, &min).is_empty());
}

#[test]
fn surfaces_that_bound_nothing_are_refused_by_name() {
    let good = cube(0.0, 1.0).to_surface();
    let refusal = |surface: &SurfaceMesh| Solid::from_surface(surface).err().unwrap();
    let mut open = good.clone();
    open.triangles.pop();
    let message = refusal(&open).to_string();
    assert!(message.contains("11 triangles") && message.contains("Not Manifold"), "{message}");
    let mut reversed = good.clone();
    reversed.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(matches!(refusal(&reversed), SolidError::InsideOut { volume } if volume < -0.99));
    let mut infinite = good.clone();
    infinite.vertices[0].x = f64::NAN;
    assert!(refusal(&infinite).to_string().contains("Non-Finite"));
}

#[test]
fn labels_follow_faces_through_booleans_and_motions() {
    let block = cube(0.0, 1.0).to_surface();
    let labels: Vec<u32> =
        (0..12).map(|t| if block.centroid(t).z > 0.999 { 7 } else { 3 }).collect();
    let block = Solid::from_labelled_surface(&block, &labels).unwrap();
    let drill = Solid::cylinder(&Vec3::new(0.5, 0.5, -1.0), &(Vec3::z() * 3.0), 0.2, 0.2, 24);
    let (block_id, drill_id) = (block.id().unwrap(), drill.id().unwrap());
    assert_ne!(block_id, drill_id);
    let result = block.difference(&drill).translate(&Vec3::new(0.0, 0.0, 5.0));
    assert_eq!(result.id(), None);
    let (surface, origins) = result.to_surface_with_origin();
    assert_eq!(surface.triangles.len(), origins.len());
    for (t, origin) in origins.iter().enumerate() {
        let x = surface.centroid(t);
        let from_axis = (x.x - 0.5).hypot(x.y - 0.5);
        let expected = if (5.0001..5.9999).contains(&x.z) && from_axis < 0.3 {
            (drill_id, None)
        } else {
            (block_id, Some(if x.z > 5.999 { 7 } else { 3 }))
        };
        assert_eq!((origin.solid, expected.1.map(|_| origin.face)), expected, "{x:?}");
    }
}

#[test]
fn cylinders_stand_on_their_axis() {
    let (base, axis) = (Vec3::new(0.01, 0.02, 0.03), Vec3::new(0.003, -0.002, 0.005));
    let n = 200;
    let cone = Solid::cylinder(&base, &axis, 0.002, 0.001, n);
    // Inscribed polygon: area factor n sin(2π/n) / 2π; frustum (r² + rs + s²)/3.
    let polygon = n as f64 * (2.0 * PI / n as f64).sin() / 2.0;
    let volume = polygon * axis.norm() * (4.0 + 2.0 + 1.0) * 1e-6 / 3.0;
    assert!(relative(cone.volume(), volume) < 1e-12);
    let at = |x: &Vec3| (x - base).dot(&axis) / axis.norm_squared();
    for x in &cone.to_surface().vertices {
        let (s, radius) = (at(x), (x - base).cross(&axis).norm() / axis.norm());
        assert!(s.abs() < 1e-12 || (s - 1.0).abs() < 1e-12);
        assert!((radius - (0.002 - 0.001 * s)).abs() < 1e-15);
    }
    assert!(Solid::cylinder(&base, &axis, 0.0, 0.0, 8).is_empty());
    assert!(
        relative(Solid::cylinder(&base, &axis, 0.002, 0.0, n).volume(), 4.0 / 7.0 * volume) < 1e-12
    );
}

#[test]
fn extrusions_have_holes() {
    let square = |r: f64| vec![[-r, -r], [r, -r], [r, r], [-r, r]];
    let hole: Vec<_> = square(0.5).into_iter().rev().collect();
    let frame = Solid::extrude(&[square(1.0), hole], -0.25, 0.75);
    assert!(relative(frame.volume(), 3.0) < 1e-14);
    assert_eq!(frame.genus(), 1);
    assert_eq!((frame.bounds().0.z, frame.bounds().1.z), (-0.25, 0.75));
    assert!(Solid::extrude(&[], 0.0, 1.0).is_empty());
}

#[test]
fn a_cut_along_a_coordinate_plane_is_exact() {
    let ball = Solid::sphere(&Vec3::new(0.003, 0.001, 0.002), 0.035, 64);
    for (axis, sign) in [(0, 1.0), (1, 1.0), (2, 1.0), (0, -1.0), (1, -1.0), (2, -1.0)] {
        let mut normal = Vec3::zeros();
        normal[axis] = sign;
        let (beyond, before) = ball.split_by_plane(&normal, 0.0037);
        assert!(relative(beyond.volume() + before.volume(), ball.volume()) < 1e-12);
        let cut = 0.0037 * sign;
        let wrong = beyond.to_surface().vertices.iter().any(|v| v[axis] * sign < 0.0037);
        assert!(!wrong);
        let on_plane = before.to_surface().vertices.iter().filter(|v| v[axis] == cut).count();
        assert!(on_plane > 20, "{on_plane}");
        assert_eq!(ball.trim_by_plane(&normal, 0.0037).volume(), beyond.volume());
    }
}

#[test]
fn bodies_keep_their_cavities() {
    let hollow = cube(0.0, 1.0).difference(&cube(0.25, 0.75));
    let inner = cube(0.4, 0.6);
    let both = hollow.union(&inner).union(&cube(3.0, 4.0));
    let mut volumes: Vec<f64> = both.decompose().iter().map(Solid::volume).collect();
    volumes.sort_by(f64::total_cmp);
    for (volume, expected) in volumes.iter().zip([0.008, 0.875, 1.0]) {
        assert!(relative(*volume, expected) < 1e-14);
    }
    assert_eq!(volumes.len(), 3);
    assert!(Solid::hull(&[]).decompose().is_empty());
}

#[test]
fn reflections_keep_the_outside_outside() {
    let wedge = Solid::hull(&[Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]);
    let map = Matrix3x4::new(
        -2.0, 0.0, 0.0, 5.0, //
        0.0, 1.0, 0.0, 0.0, //
        0.0, 0.0, 1.0, 0.0,
    );
    let image = wedge.transform(&map);
    assert!((enclosed_volume(&image.to_surface()) - 1.0 / 3.0).abs() < 1e-15);
    assert_eq!(image.bounds().1.x, 5.0);
}

#[test]
fn simplification_stays_within_its_tolerance() {
    let (radius, tolerance) = (0.035, 2e-4);
    let fine = Solid::sphere(&Vec3::zeros(), radius, 512);
    let coarse = fine.simplify(tolerance);
    let count = |solid: &Solid| solid.to_surface().triangles.len();
    assert!(count(&coarse) < count(&fine) / 3);
    assert!(coarse.area() * tolerance > (coarse.volume() - fine.volume()).abs());
    let surface = coarse.to_surface();
    let depths = (0..surface.triangles.len()).map(|t| radius - surface.centroid(t).norm());
    // The chord of a triangle adds to the displacement of its corners.
    assert!(depths.fold(0.0, f64::max) < 2.0 * tolerance);
}
