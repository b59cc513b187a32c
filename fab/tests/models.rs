//! Bodies with a model, of which a part may have been designed since.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CELL, CHAMBER, Scene};
use mesh::Vec3;
use mesh::io::{read_tets, write_surface, write_tets};
use mesh::topology::boundary;

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
    let with_model = || scene.mold_with(&["--model", "model.stl"]);
    model(0.13);
    let made = with_model();
    made.good();
    let verified = scene.assert_verified();
    assert!(verified.contains("1.040 mm of the model at ("), "{verified}");
    // The model is cast, from which the tetrahedra are 0.08 mm away.
    for line in ["ok surface: mold to CAD ", "ok surface: mold to design 0.08"] {
        assert!(verified.contains(line), "{verified}");
    }
    scene.configure("method = \"soluble\"\nsurface = \"mesh\"\ncasting.least_wall = 5e-4");
    with_model().good();
    let of_mesh = scene.verify().words();
    assert!(of_mesh.contains("warn surface: mold to CAD 0.08"), "{of_mesh}");
    scene.configure("method = \"soluble\"");

    model(0.12);
    let changed = scene.verify().stdout;
    assert!(changed.contains("has changed since"), "{changed}");
    with_model().ended(2, &["of the model, casting.least_wall is 1.000 mm"]);
    // The model of another body.
    model(0.2);
    with_model().ended(2, &["up to 0.640 mm from it"]);
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
    scene.mold_with(&["--model", "model.stl"]).ended(2, &[]);
    scene.mold_with(&["--model", "model.stl", "--from", "tagged.msh"]).good();
    let said = scene.assert_verified();
    assert!(said.contains("ok surface: mold to design 0.1"), "{said}");
    let report = scene.report(".");
    // 181 cubes of 64 mm³, less 12 × 12 × 1 mm, with a layer of 28 × 24 × 0.1 mm.
    let volume = 181.0 * 64.0 - 144.0 + 28.0 * 24.0 * 0.1;
    assert!((report.cast.volume - volume).abs() < 0.05, "{}", report.cast.volume);
}
