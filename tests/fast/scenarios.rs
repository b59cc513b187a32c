//! One design under several scenarios: what each comes to, gradients, and interrupted runs.

use mechanics::body::Body;
use mechanics::extension::Extension;
use mesh::Vec3;
use mesh::io::{read_tets, write_tets};
use mesh::offset::shifts;
use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

use crate::resume::{assert_same, killed_when_at, results};

/// How far walls are off [m].
const WALL: f64 = 0.3e-3;

const SCENARIOS: &str = r#"
[[scenario]]
name = "as drawn"
weight = 2

[[scenario]]
name = "thin"
wall = -0.3e-3

[[scenario]]
name = "soft"
modulus = 0.8
pressure = 200

[[scenario]]
name = "less"
wall = { top = 0.2e-3 }
parameters = { p = 7e3 }
weights = { top = 0.5, smooth = 0 }
"#;

/// The chamber and its design with linear elements, and these tables.
pub fn workdir(more: &str) -> Workdir {
    let dir = chamber::workdir();
    let scene = dir.text("p1.toml").replace("pressure = 8e3", "pressure = \"p*t\"");
    dir.write("p1.toml", &(scene + "\n[parameters]\np = 8e3\n"));
    dir.write("design.toml", &(dir.text("design.toml") + SCENARIOS + more));
    dir
}

fn first_line(dir: &Workdir, folder: &str) -> Value {
    let history = dir.text(&format!("{folder}/history.jsonl"));
    serde_json::from_str(history.lines().next().unwrap()).unwrap()
}

/// The objective of the design as it begins, in the history.
fn objective_at_start(dir: &Workdir, design: &str) -> f64 {
    dir.write("one.toml", design);
    dir.solver("-q optimize one.toml -o one --restart").assert_good();
    first_line(dir, "one")["objective"].as_f64().unwrap()
}

/// A mesh with all walls moved outward, in place of the scene's.
fn move_walls(dir: &Workdir, distance: f64) {
    let file = read_tets(&dir.path("body.msh")).unwrap();
    let mut body = Body::new(file.mesh, file.tags);
    let mut moves = vec![Vec3::zeros(); body.mesh.vertices.len()];
    for (v, d) in shifts(&body.mesh.vertices, body.boundary()) {
        moves[v] = d;
    }
    Extension::new(&body).unwrap().apply(&mut moves);
    body.mesh.vertices.iter_mut().zip(moves).for_each(|(x, d)| *x += distance * d);
    write_tets(&dir.path("moved.msh"), &body.mesh, &body.tags).unwrap();
}

/// Each scenario comes to what a scene with those numbers comes to, and the objective to the
/// weighted mean.
#[test]
fn scenarios_are_scenes_with_numbers_changed() {
    let dir = workdir("");
    let one = chamber::DESIGN.replace("sim.toml", "other.toml");
    dir.solver("-q optimize design.toml -o out").assert_good();
    let line = first_line(&dir, "out");
    let scene = dir.text("p1.toml");
    move_walls(&dir, -WALL);
    let soft = [("55e3", 55e3), ("5e3", 5e3), ("1.7e3", 1.7e3), ("1e6", 1e6)];
    let soft =
        soft.iter().zip(["c1", "c2", "c3", "d1"]).fold(scene.clone(), |text, ((old, p), key)| {
            text.replace(&format!("{key} = {old}"), &format!("{key} = {:e}", 0.8 * p))
        });
    let scenes = [
        ("as drawn", scene.clone()),
        ("thin", scene.replace("body.msh", "moved.msh")),
        ("soft", soft.replace("\"p*t\"", "\"p*t + 200*t\"")),
    ];
    for (name, scene) in scenes {
        dir.write("other.toml", &scene);
        let (found, expected) = (
            line["scenarios"][name]["objective"].as_f64().unwrap(),
            objective_at_start(&dir, &one),
        );
        assert!((found / expected - 1.0).abs() < 1e-9, "{name}: {found} and {expected}");
    }
    let of = |name: &str, term: &str| line["scenarios"][name]["terms"][term].as_f64().unwrap();
    assert_eq!(of("less", "smooth"), 0.0);
    assert!(of("as drawn", "smooth") > 0.0);
    let total = |name: &str| line["scenarios"][name]["objective"].as_f64().unwrap();
    let mean = (2.0 * total("as drawn") + total("thin") + total("soft") + total("less")) / 5.0;
    assert!((line["objective"].as_f64().unwrap() / mean - 1.0).abs() < 1e-12);
    let moved = ["as drawn", "thin", "soft", "less"]
        .map(|name| line["scenarios"][name]["mean_displacement"]["top"].as_f64().unwrap());
    let (low, high) = moved.iter().fold((f64::MAX, 0.0_f64), |(l, h), &m| (m.min(l), m.max(h)));
    let spread = line["spread"]["top"].as_f64().unwrap();
    assert!((spread - (high - low) / moved[0]).abs() < 1e-12 && spread > 0.1, "{spread}");
    let report = dir.json("out/report.json");
    assert_eq!(report["scenarios_before"], line["scenarios"]);
    assert!(report["objective_after"].as_f64() < report["objective_before"].as_f64());
}

#[test]
fn the_worst_of_one_scenario_is_refused() {
    let dir = chamber::workdir();
    dir.write("design.toml", &(dir.text("design.toml") + "[robust]\nworst = 1\n"));
    dir.solver("optimize design.toml -o out").assert_refused(2, &["[robust]", "two or more"]);
}

/// By all design variables and all parameters, for each way to make one objective.
#[test]
fn gradients_are_exact() {
    for robust in ["", "[robust]\ndeviations = 1.5\n", "[robust]\nworst = 20\n"] {
        let dir = workdir(robust);
        let run = dir.solver("check design.toml");
        run.assert_good();
        let tested = run.stdout.contains("\"excess\" by shape");
        assert_eq!(tested, !robust.is_empty(), "{}", run.stdout);
        assert!(run.stdout.contains("\"top\" by material"), "{}", run.stdout);
    }
}

/// A pressure that is designed and off, in a scene through time.
#[test]
fn gradients_by_designed_pressures_are_exact() {
    let dir = workdir("");
    let time = "[time]\nmethod = \"quasistatic\"\nend = 0.5\nsteps = 2\n";
    dir.write(
        "p1.toml",
        &dir.text("p1.toml").replace("[parameters]", &format!("{time}[parameters]")),
    );
    let designed = "[[parameter]]\nname = \"q\"\nbounds = [0, 1e3]\n";
    let scene = dir.text("p1.toml").replace("\"p*t\"", "\"p*t + q*t^2\"");
    dir.write("p1.toml", &(scene + "q = 100\n"));
    dir.write("design.toml", &(dir.text("design.toml") + designed));
    let run = dir.solver("check design.toml --design-only");
    run.assert_good();
    assert!(run.stdout.contains("\"top\" by loads"), "{}", run.stdout);
}

/// As one that is not interrupted, to the bit; a weight that was found from a share at the start is that of the whole
/// design.
#[test]
fn an_interrupted_design_continues() {
    let folder = || {
        let dir = workdir("[robust]\ndeviations = 1\n");
        let shared = dir.text("design.toml").replacen("weight = 1e10", "share = 0.9", 1);
        dir.write("design.toml", &shared);
        dir
    };
    let dir = folder();
    dir.solver("--threads 2 -q optimize design.toml -o out").assert_good();
    let expected = results(&dir);
    let dir = folder();
    assert!(killed_when_at(&dir, 2) && killed_when_at(&dir, 5), "finished before it was killed");
    dir.solver("--threads 1 -q optimize design.toml -o out").assert_good();
    assert_same(&dir, &expected);
}
