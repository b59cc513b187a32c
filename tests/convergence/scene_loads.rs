//! A scene with every kind of load and support, as `solver simulate` reads it.

use mechanics::forward::solve;
use mesh::Vec3;
use run::report::results;
use scene::Scene;
use tests::{block, tag};

/// A bar that is held, pulled sideways by its end, heavy, and blown up.
const SCENE: &str = r#"
mesh = "bar.msh"
degree = 3

[material]
kind = "mooney-rivlin"
c1 = 55e3
c2 = 5e3
c3 = 1.7e3
d1 = 1e6

[[fixed]]
on = "root"

[[fixed]]
on = "end"
components = "xz"
displacement = [4e-3, 0.0, 2e-3]

[[body_force]]
force = [0.0, 0.0, -9810.0]

[[traction]]
on = "top"
traction = [100.0, 0.0, -300.0]

[[chamber]]
on = "hole"
pressure = 2e3
"#;

#[test]
fn reactions_balance_every_load() {
    let folder = tempfile::tempdir().unwrap();
    let hole = |p: Vec3| (p - Vec3::new(0.025, 0.015, 0.015)).amax() < 0.0055;
    let mesh = block([5, 3, 3], 0.01, |c| c == [2, 1, 1], |p| p);
    let body = tag(
        mesh,
        &[
            ("root", &|p| p.x < 1e-9),
            ("end", &|p| p.x > 0.05 - 1e-9),
            ("top", &|p| p.z > 0.03 - 1e-9),
            ("hole", &hole),
        ],
    );
    mesh::io::write_tets(&folder.path().join("bar.msh"), &body.mesh, &body.tags).unwrap();
    let path = folder.path().join("sim.toml");
    std::fs::write(&path, SCENE).unwrap();

    let scene = Scene::read(&path).unwrap();
    let (problem, mut workspace) = scene.problem(&scene.body).unwrap();
    let rest = scene.body.mesh.vertices.clone();
    let solution = solve(&problem, &mut workspace, &rest, &scene.stepping(), |_| ()).unwrap();
    assert!(solution.steps.iter().all(|s| s.smallest_volume_ratio > 0.0));

    let at = problem.iterate(&rest, &solution.u, 1.0);
    let balance = results::balance(&problem, &at);
    let weight = 9810.0 * (45.0 - 1.0) * 1e-6;
    let [body_force, traction, pressure, reaction] =
        ["body_force", "traction", "chamber", "reaction"]
            .map(|key| Vec3::from(balance.resultants[key]));
    assert!((body_force + weight * Vec3::z()).norm() < 1e-12);
    assert!((traction - 15e-4 * Vec3::new(100.0, 0.0, -300.0)).norm() < 1e-12);
    assert!(pressure.norm() < 1e-12, "a closed wall has no resultant: {pressure}");
    assert!((body_force + traction + reaction).norm() < 1e-9, "{balance:?}");
    assert!(balance.out_of_balance < 1e-9);

    let tags = results::tags(&scene, &scene.body, &problem, &at).unwrap();
    let [root, end, top] = ["root", "end", "top"].map(|name| Vec3::from(tags[name].reaction));
    assert!((root + end - reaction).norm() < 1e-9);
    assert!(end.x > 0.1 && end.y == 0.0, "the end is pulled and free along y: {end}");
    assert_eq!(top, Vec3::zeros());
    let moved = tags["end"].mean_displacement_vector;
    assert!((moved[0] - 4e-3).abs() < 1e-15 && (moved[2] - 2e-3).abs() < 1e-15, "{moved:?}");
}

#[test]
fn a_wall_whose_rim_leaves_its_plane_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = block([3, 3, 3], 0.01, |c| c == [0, 1, 1], |p| p);
    let hole = |p: Vec3| (p - Vec3::new(0.005, 0.015, 0.015)).amax() < 0.0055;
    let body =
        tag(mesh, &[("hole", &hole), ("mouth", &|p| p.x < 1e-9), ("end", &|p| p.x > 0.03 - 1e-9)]);
    mesh::io::write_tets(&folder.path().join("bar.msh"), &body.mesh, &body.tags).unwrap();
    let material = &SCENE[..SCENE.find("[[fixed]]").unwrap()];
    let path = folder.path().join("sim.toml");
    let scene = |components: &str| {
        let rest = format!(
            "[[fixed]]\non = \"end\"\n[[fixed]]\non = \"mouth\"\ncomponents = \"{components}\"\n\
             [[chamber]]\non = \"hole\"\npressure = 1e3\n"
        );
        std::fs::write(&path, format!("{material}{rest}")).unwrap();
        let scene = Scene::read(&path).unwrap();
        scene.problem(&scene.body).map(|_| ())
    };
    // the rim lies in the plane x = 0
    let error = format!("{:#}", scene("yz").unwrap_err());
    assert!(error.contains("4 of the 4 edges") && error.contains("along x, y and z"), "{error}");
    scene("xy").unwrap();
    scene("xyz").unwrap();
}
