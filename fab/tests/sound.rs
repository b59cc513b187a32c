//! Sound bodies that once failed a check of their own mold.

#![allow(clippy::unwrap_used)]

use std::process::Output;

use crate::fixture::{CELL, CHAMBER, CLOSED, Cubes, Scene, TWO_TOPS, fab_in, stderr, stdout};
use mesh::Vec3;
use mesh::io::{read_tets, write_surface, write_tets};
use mesh::topology::boundary;
use nalgebra::{Rotation3, Unit};

/// Runs `fab mold` with more options, in the folder of the scene.
fn with_files(scene: &Scene, more: &[&str]) -> Output {
    let own = ["mold", "design.msh", "--config", "mold.toml", "-o", "mold", "--no-pictures"];
    fab_in(&scene.path(""), &[&own, more].concat())
}

/// Standard output of a run with single spaces.
fn words(output: &Output) -> String {
    stdout(output).split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn a_vent_of_a_large_body_is_measured_by_its_own_size() {
    // 216 mm long: rounding of the whole body exceeds what the mouth of a vent holds.
    Scene::planned(&TWO_TOPS, "method = \"soluble\"").moved(|p| *p *= 6.0).verified();
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn the_name_of_a_tray_stands_on_its_tray() {
    // The hull of a box that stands on edge has but a narrow face in front.
    let axis = Unit::new_normalize(Vec3::new(1.0, 2.0, 3.0));
    for angle in [0.3, 0.6, 0.9, 1.2] {
        let turn = Rotation3::from_axis_angle(&axis, angle).into_inner();
        let scene = Scene::planned(&CLOSED, "method = \"open-top\"");
        assert_eq!(scene.moved(|p| *p = turn * *p * 0.5).made().molds.len(), 2);
    }
}

/// A closed chamber of 8 mm in a box of 24 mm, with vertices half-way through both.
const HALVED: Cubes =
    Cubes { count: [6, 6, 6], solid: |_| true, chamber: |c| c.iter().all(|k| (2..4).contains(k)) };

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn halves_keep_their_plane_clear_of_vertices() {
    // Turned, the vertices half-way are off their plane by the rounding of a float.
    for angle in [0.0, 0.3, 0.7] {
        let axis = Unit::new_normalize(Vec3::new(1.0, 2.0, 3.0));
        let turn = Rotation3::from_axis_angle(&axis, angle).into_inner();
        let normal = turn.column(0);
        let config = format!(
            "method = \"halves\"\n[gluing]\nnormal = [{}, {}, {}]",
            normal.x, normal.y, normal.z
        );
        Scene::planned(&HALVED, &config).moved(|p| *p = turn * *p).verified();
    }
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn a_closed_box_is_halved_across_any_plane() {
    Scene::planned(&CLOSED, "method = \"halves\"\n[gluing]\nnormal = [1, 2, 3]").verified();
}

#[test]
fn an_inlet_is_not_tilted_against_the_lid_of_a_half() {
    // The inlet leaves the body across the plane, not at a slant on which the lid would lock.
    assert_eq!(Scene::planned(&CHAMBER, "method = \"halves\"").made().molds.len(), 2);
}

#[test]
fn an_inlet_too_narrow_for_a_stub_is_no_way_in() {
    // Stubs of 0.56 mm fill less than half of their sockets.
    let config = "[core]\nshoulder = 1.24e-3";
    let plan = Scene::planned(&CHAMBER, config).made();
    assert!(["open-top", "halves"].contains(&plan.method.name()), "{:?}", plan.method);
    assert!(plan.reason.contains("at least 2.073 mm"), "{}", plan.reason);
}

#[test]
fn a_tooth_that_locks_one_plane_is_freed_by_another() {
    // A box of 44 × 44 × 16 mm, cast face down with its chamber open, and a tooth of 4 mm above
    // the lid: too small to count against the plane of the lid, but it must give way by its width.
    let tooth = Cubes {
        count: [12, 11, 4],
        solid: |[i, j, k]| i < 11 || (j == 5 && k == 2),
        chamber: |[i, j, k]| {
            let within = |low: usize| (low..11 - low).contains(&i) && (low..11 - low).contains(&j);
            (k == 1 && within(2)) || (k == 2 && within(4))
        },
    };
    Scene::planned(&tooth, "").verified();
}

#[test]
fn a_wall_too_thin_is_refused_by_the_plan_with_its_place() {
    // One side of the chamber is pressed from 8 mm to 0.8 mm.
    let press = |p: &mut Vec3| {
        if p.y < 2.0 * CELL {
            p.y = 2.0 * CELL - 0.1 * (2.0 * CELL - p.y);
        }
    };
    for method in ["soluble", "halves", "open-top"] {
        let scene = Scene::planned(&CHAMBER, &format!("method = \"{method}\"")).moved(press);
        scene.refused(2, &["the silicone is 0.800 mm thick at ("]);
    }
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn walls_are_measured_on_the_model_if_it_is_that_of_the_mesh() {
    let press = |part: f64| {
        move |p: &mut Vec3| {
            if p.y < 2.0 * CELL {
                p.y = 2.0 * CELL - part * (2.0 * CELL - p.y);
            }
        }
    };
    // The mesh is within its envelope of a model of 1.04 mm.
    let scene = Scene::planned(&CHAMBER, "method = \"soluble\"").moved(press(0.12));
    scene.refused(2, &["the silicone is 0.960 mm thick"]);
    let model = |part: f64| {
        let body = Scene::planned(&CHAMBER, "").moved(press(part));
        let mesh = read_tets(&body.path("design.msh")).unwrap().mesh;
        write_surface(&scene.path("model.stl"), &boundary(&mesh).surface(&mesh).0).unwrap();
    };
    let with_model = || with_files(&scene, &["--model", "model.stl"]);
    model(0.13);
    let made = with_model();
    assert!(made.status.success(), "{}", stderr(&made));
    let verified = scene.verify();
    assert!(verified.status.success(), "{}", stdout(&verified));
    assert!(stdout(&verified).contains("1.040 mm of the model at ("), "{}", stdout(&verified));
    // The model is cast, from which the tetrahedra are 0.08 mm away.
    for line in ["ok surface: mold to CAD ", "ok surface: mold to design 0.08"] {
        assert!(words(&verified).contains(line), "{}", stdout(&verified));
    }
    scene.configure("method = \"soluble\"\nsurface = \"mesh\"\ncasting.least_wall = 5e-4");
    let made = with_model();
    assert!(made.status.success(), "{}", stderr(&made));
    let of_mesh = scene.verify();
    assert!(words(&of_mesh).contains("warn surface: mold to CAD 0.08"), "{}", stdout(&of_mesh));
    scene.configure("method = \"soluble\"");

    model(0.12);
    let changed = scene.verify();
    assert!(stdout(&changed).contains("has changed since"), "{}", stdout(&changed));
    let thin = with_model();
    assert_eq!(thin.status.code(), Some(2));
    assert!(stderr(&thin).contains("of the model, casting.least_wall is 1.000 mm"));
    // The model of another body.
    model(0.2);
    let other = with_model();
    assert_eq!(other.status.code(), Some(2));
    assert!(stderr(&other).contains("up to 0.640 mm from it"), "{}", stderr(&other));
}

/// The chamber and what a design makes of it, with a model whose outside is 0.1 mm wider than the mesh.
#[test]
fn of_a_design_what_did_not_move_is_cast_as_in_the_model() {
    let scene = Scene::new(&CHAMBER, "core.support = \"stub\"");
    let file = read_tets(&scene.path("design.msh")).unwrap();
    write_tets(&scene.path("tagged.msh"), &file.mesh, &file.tags).unwrap();
    let mut model = boundary(&file.mesh).surface(&file.mesh).0;
    let wide = 5.0 * CELL - 1e-9;
    model.vertices.iter_mut().filter(|p| p.x > wide).for_each(|p| p.x += 1e-4);
    write_surface(&scene.path("model.stl"), &model).unwrap();
    // The ceiling of the chamber, at 20 mm, is designed 1 mm higher.
    let mut design = file.mesh.clone();
    let inside = |p: &&mut Vec3| {
        p.z > 4.9 * CELL
            && p.z < 5.1 * CELL
            && p.x > 0.9 * CELL
            && p.x < 4.1 * CELL
            && p.y > 1.9 * CELL
            && p.y < 5.1 * CELL
    };
    design.vertices.iter_mut().filter(inside).for_each(|p| p.z += 1e-3);
    write_tets(&scene.path("design.msh"), &design, &file.tags).unwrap();
    // A model is not that of a design.
    let alone = with_files(&scene, &["--model", "model.stl"]);
    assert_eq!(alone.status.code(), Some(2), "{}", stderr(&alone));
    let made = with_files(&scene, &["--model", "model.stl", "--from", "tagged.msh"]);
    assert!(made.status.success(), "{}", stderr(&made));
    let verified = scene.verify();
    let said = stdout(&verified);
    assert!(verified.status.success(), "{said}");
    assert!(words(&verified).contains("ok surface: mold to design 0.1"), "{said}");
    let report = scene.report(".");
    // 181 cubes of 64 mm³, less 12 × 12 × 1 mm, with a layer of 28 × 24 × 0.1 mm.
    let volume = 181.0 * 64.0 - 144.0 + 28.0 * 24.0 * 0.1;
    assert!((report.cast.volume - volume).abs() < 0.05, "{}", report.cast.volume);
}
