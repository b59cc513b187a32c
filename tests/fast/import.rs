//! `solver import` of the scenes that were published with Gjoka et al. 2024.
//! What is expected was counted with scripts of their own on the same files.
// 6.28 as the scenes have it, not 2π
#![allow(clippy::approx_constant)]

use mechanics::body::Body;
use mechanics::forward::Method;
use mesh::Vec3;
use mesh::measure::{bounds, volume};
use polyfem::{self, Options};
use scene::Scene;
use scene::config::ContactForm;
use tests::published::FOLDER;
use tests::workdir::Workdir;

/// Imports a published file into a folder and reads what was written.
fn imported(file: &str, options: &Options) -> Option<(Workdir, Scene)> {
    let path = tests::shared(&format!("{FOLDER}/{file}"))?;
    let dir = Workdir::new();
    let imported = polyfem::read(&path, options).unwrap();
    let unknown = |why: &&String| why.contains("unknown key");
    assert_eq!(imported.left().keys().find(unknown), None, "all keys of {file} are known");
    imported.write(&dir.path("")).unwrap();
    let scene = Scene::read(&dir.path("sim.toml")).unwrap();
    Some((dir, scene))
}

/// Asserts numbers of facets and vertices of tags.
fn has(body: &Body, name: &str, expected: &[(&str, usize, usize)]) {
    for &(tag, facets, vertices) in expected {
        let own = body.facets(&format!("{name}.{tag}")).unwrap();
        let mut found: Vec<usize> = own.iter().flatten().copied().collect();
        found.sort_unstable();
        found.dedup();
        assert_eq!((own.len(), found.len()), (facets, vertices), "{name}.{tag}");
    }
}

/// The mesh of one of several bodies, from the file that was written.
fn part(dir: &Workdir, name: &str) -> mesh::TetMesh {
    mesh::io::read_tets(&dir.path(&format!("{name}.msh"))).unwrap().mesh
}

/// Bounds that were written down with 0.1 mm.
fn lies_between(mesh: &mesh::TetMesh, low: [f64; 3], high: [f64; 3]) {
    let (a, b) = bounds(&mesh.vertices);
    for (found, expected) in [(a, low), (b, high)] {
        assert!((found - Vec3::from(expected)).amax() < 0.6e-4, "{found:?} {expected:?}");
    }
}

fn pressure(scene: &Scene, on: &str, t: f64) -> f64 {
    let chamber = scene.config.chamber.iter().find(|c| c.name == on).unwrap();
    scene.config.schedule(chamber.gas.pressure().unwrap()).at(t)
}

fn close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected}");
}

#[test]
fn the_gripper_and_its_cylinder() {
    let state = "gripper_bellows/state_gripper_bellows.json";
    let Some((dir, scene)) = imported(state, &Options::default()) else { return };
    let (gripper, cylinder) = ("gripper_bellows_thick", "cylinder_to_grasp_coarse");
    let expected = [("s1", 710, 395), ("s2", 2932, 1485), ("s3", 5348, 2804), ("s4", 1177, 699)];
    has(&scene.body, gripper, &expected);
    assert_eq!(scene.body.facets(&format!("{gripper}.unselected")).unwrap().len(), 2137);
    let mesh = part(&dir, gripper);
    assert_eq!((mesh.vertices.len(), mesh.tets.len()), (11587, 49500));
    close(volume(&mesh), 1.1267e-4, 1e-4);
    lies_between(&mesh, [-0.0231, -0.0141, -0.0290], [0.0230, 0.0280, 0.1060]);
    let mesh = part(&dir, cylinder);
    assert_eq!((mesh.vertices.len(), mesh.tets.len()), (1622, 5261));
    lies_between(&mesh, [-0.0325, -0.0704, -0.0183], [0.0325, -0.0119, 0.0403]);
    let on: Vec<&String> = scene.config.fixed.iter().map(|f| &f.on).collect();
    assert_eq!(on, [&format!("{gripper}.s1"), &format!("{cylinder}.s1")]);
    for (t, expected) in [(0.02, 60e3 * (0.03 - 4e-6)), (0.5, 60e3 * 0.6875), (1.06, 60e3)] {
        close(pressure(&scene, &format!("{gripper}.s2"), t), expected, 1e-14);
    }
    let contact = scene.config.contact().unwrap();
    assert_eq!((contact.form, contact.activation), (ContactForm::Plain, Some(3e-5)));
    assert_eq!((contact.stiffness, contact.friction), (Some(1e5), 0.7));
    assert_eq!((scene.times().len(), scene.end()), (55, 1.1));
    assert_eq!(scene.config.method(), Method::ImplicitEuler);
}

#[test]
fn the_worm_and_its_floor() {
    let Some((dir, scene)) = imported("worm/state_worm.json", &Options::default()) else { return };
    let worm = "worm_long_clean";
    has(&scene.body, worm, &[("s1", 2706, 1429), ("s20", 167, 104), ("s21", 769, 449)]);
    let mesh = part(&dir, worm);
    assert_eq!((mesh.vertices.len(), mesh.tets.len()), (4763, 18588));
    close(volume(&mesh), 6.757e-4, 1e-4);
    lies_between(&mesh, [-0.27, -0.0229, -0.0179], [0.27, 0.0229, 0.0181]);
    let floor = part(&dir, "cube");
    lies_between(&floor, [-0.5, -0.5, -0.029], [0.5, 0.5, -0.019]);
    assert_eq!(scene.body.facets("cube.s30").unwrap().len(), 12);
    // ten chambers of 10.45 ml that swell one after the other
    let order = [11, 7, 10, 9, 3, 2, 8, 6, 5, 4];
    let amplitudes = [28e3, 29e3, 30e3, 31e3, 32e3, 32e3, 32e3, 32e3, 32e3, 32e3];
    for (i, (id, amplitude)) in order.into_iter().zip(amplitudes).enumerate() {
        let on = format!("{worm}.s{id}");
        let delay = 0.1 * i as f64;
        for t in [0.01, 0.5, 1.3, 3.0] {
            let since: f64 = (t - delay).max(0.0);
            close(pressure(&scene, &on, t), amplitude * (1.0 - (6.28 * since).cos()), 1e-9);
        }
        let facets = scene.body.facets(&on).unwrap();
        assert!((256..=322).contains(&facets.len()));
        let corners = facets.iter().map(|f| f.map(|v| scene.body.mesh.vertices[v]));
        close(corners.map(|[a, b, c]| -a.dot(&b.cross(&c)) / 6.0).sum(), 1.045e-5, 0.01);
    }
    assert_eq!(
        scene.config.field(&scene.config.gravity).at(Vec3::zeros(), 1.0),
        Vec3::new(0.0, 0.0, -9.8)
    );
    assert_eq!(scene.config.contact().unwrap().form, ContactForm::Convergent);
    assert_eq!((scene.times().len(), scene.end()), (300, 3.0));
}

#[test]
fn the_walker_as_a_slab() {
    let options = Options { form: None, thickness: Some(0.02) };
    let Some((dir, scene)) = imported("walker/state_walker.json", &options) else { return };
    let mesh = part(&dir, "walker");
    assert_eq!((mesh.vertices.len(), mesh.tets.len()), (2 * 192, 3 * 310));
    // a body of 4.4 × 3.2 with a gap of 1.6 × 1.2 between its legs and two holes
    // of 0.6 × 1.8, times 0.1
    let area = 0.44 * 0.32 - 0.16 * 0.12 - 2.0 * 0.06 * 0.18;
    close(volume(&mesh), area * 0.02, 1e-12);
    lies_between(&mesh, [-0.22, -0.12, 0.0], [0.22, 0.2, 0.02]);
    let floor = part(&dir, "square");
    lies_between(&floor, [-1.0, -0.135, 0.0], [1.0, -0.125, 0.02]);
    // chambers are the holes and nothing else: 2 (0.06 + 0.18) around
    for tag in ["s2", "s3"] {
        let facets = scene.body.facets(&format!("walker.{tag}")).unwrap();
        let corners = facets.iter().map(|f| f.map(|v| scene.body.mesh.vertices[v]));
        let area = corners.map(|[a, b, c]| mesh::measure::triangle_area(a, b, c)).sum();
        close(area, 0.02 * 2.0 * (0.06 + 0.18), 1e-12);
    }
    // the lists are rounded cosines, the second 0.3 s late
    for step in 1..=200 {
        let t = scene.times()[step - 1];
        let wave = |t: f64| 750.0 * (1.0 - (6.28 * t.max(0.0)).cos());
        assert!((pressure(&scene, "walker.s3", t) - wave(t)).abs() < 1e-3, "{t}");
        assert!((pressure(&scene, "walker.s2", t) - wave(t - 0.3)).abs() < 1e-3, "{t}");
    }
    assert_eq!(
        scene.config.field(&scene.config.gravity).at(Vec3::zeros(), 1.0),
        Vec3::new(0.0, -1.0, 0.0)
    );
    let moduli = scene.laws[0].material.moduli();
    close(moduli.shear, 37037.04, 1e-7);
    close(moduli.bulk - 2.0 / 3.0 * moduli.shear, 39886.04, 1e-7);
    assert_eq!((scene.times().len(), scene.end()), (200, 4.0));
}

#[test]
fn what_cannot_be_imported_leaves_nothing_behind() {
    for (file, words) in [
        (
            "frog/state_frog_quasistatic.json",
            &["state_frog_quasistatic.json", "frog_base_mesh.msh"],
        ),
        ("finger/state_finger.json", &["state_finger.json", "finger_base_mesh.msh"]),
    ] {
        let Some(path) = tests::shared(&format!("{FOLDER}/{file}")) else { return };
        let dir = Workdir::new();
        let run = dir.solver(&format!("import {} -o out", path.display()));
        run.assert_refused(2, words);
        run.assert_refused(2, &["/geometry/0/mesh: there is no file", "put it there"]);
        assert_eq!(dir.files("out"), [""; 0]);
    }
    let dir = Workdir::new();
    dir.write("bad.json", "{");
    dir.solver("import bad.json -o out").assert_refused(2, &["bad.json: not JSON"]);
    dir.solver("import absent.json -o out").assert_refused(2, &["absent.json"]);
}

#[test]
fn the_program_warns_and_writes_what_it_says() {
    let Some(path) = tests::shared(&format!("{FOLDER}/walker/state_walker.json")) else { return };
    let dir = Workdir::new();
    let run = dir.solver(&format!("import {} -o out --thickness 0.01", path.display()));
    run.assert_good();
    for words in ["/solver/linear/solver", "0.010000 m thick", "wrote out/sim.toml"] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    let names = ["import.report.json", "sim.toml", "square.msh", "walker.msh"];
    assert_eq!(dir.files("out"), names);
}
