//! One design under several scenarios: what each comes to, and gradients. And numbers of a scene by their paths.

use mechanics::body::Body;
use mechanics::extension::Extension;
use mesh::Vec3;
use mesh::io::read_tets;
use mesh::offset::shifts;
use rayon::prelude::*;
use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

use crate::samples::*;

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

pub fn first_line(dir: &Workdir, folder: &str) -> Value {
    dir.lines(&format!("{folder}/history.jsonl")).swap_remove(0)
}

/// The objective of the design as it begins, in the history.
pub fn objective_at_start(dir: &Workdir, design: &str) -> f64 {
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
    dir.put("moved.msh", &body);
}

/// A scenario, and the scene that it stands for.
struct Told {
    folder: fn() -> Workdir,
    /// Keys of the scenario; `numbers` are tried as a table of the scene, too.
    keys: &'static str,
    by_hand: &'static [(&'static str, &'static str)],
}

/// Two laws with densities, under gravity.
fn heavy() -> Workdir {
    let laws = TWO
        .replace("young = 600e3", "density = 1000\nyoung = 600e3")
        .replace("c1 = 55e3", "density = 1200\nc1 = 55e3");
    let dir = volumes(&laws);
    dir.write("p1.toml", &("gravity = [0, 0, -9.81]\n".to_owned() + &dir.text("p1.toml")));
    dir
}

const TOLD: &[Told] = &[
    Told {
        folder: || workdir(""),
        keys: "modulus = 0.8\npressure = 200",
        by_hand: &[
            ("c1 = 55e3", "c1 = 44e3"),
            ("c2 = 5e3", "c2 = 4e3"),
            ("c3 = 1.7e3", "c3 = 1.36e3"),
            ("d1 = 1e6", "d1 = 8e5"),
            ("\"p*t\"", "\"p*t + 200*t\""),
        ],
    },
    Told {
        folder: || workdir(""),
        keys: "numbers = { \"material.body.c1\" = 60e3, \"chamber.cavity.pressure\" = 500 }",
        by_hand: &[("55e3", "60e3"), ("\"p*t\"", "\"p*t + 500*t\"")],
    },
    Told {
        folder: || wound(&(FIBRE_PROFILES.to_owned() + WINDING_PROFILES)),
        keys: "numbers = { \"fibre.weave.angle.2\" = 20, \"fibre.weave.k1.2\" = 5e5, \
               \"winding.thread.stiffness.1\" = 100, \"winding.thread.pretension\" = 1 }",
        by_hand: &[
            ("[70, 40, 55]", "[70, 20, 55]"),
            ("[1e5, 3e5]", "[1e5, 5e5]"),
            ("[40, 60]", "[100, 60]"),
            ("pretension = 0.5", "pretension = 1"),
        ],
    },
    Told {
        folder: || covered(FABRIC),
        keys: "numbers = { \"membrane.top.angle\" = 0 }",
        by_hand: &[("angle = 30", "angle = 0")],
    },
    Told {
        folder: || covered(SHEET),
        keys: "membrane = 0.5",
        by_hand: &[("thickness = 1e-4", "thickness = 0.5e-4")],
    },
    Told {
        folder: heavy,
        keys: "modulus = { floor = 1.1, walls = 0.9 }",
        by_hand: &[
            ("young = 600e3", "young = 660e3"),
            ("c1 = 55e3", "c1 = 49.5e3"),
            ("c2 = 5e3", "c2 = 4.5e3"),
            ("c3 = 1.7e3", "c3 = 1.53e3"),
            ("d1 = 1e6", "d1 = 9e5"),
        ],
    },
    Told {
        folder: heavy,
        keys: "density = 2.0",
        by_hand: &[("density = 1000", "density = 2000"), ("density = 1200", "density = 2400")],
    },
    Told {
        folder: heavy,
        keys: "density = { walls = 3.0 }",
        by_hand: &[("density = 1200", "density = 3600")],
    },
];

impl Told {
    fn check(&self) {
        let (dir, keys) = ((self.folder)(), self.keys);
        let design = dir.text("design.toml").replace("iterations = 3", "iterations = 1");
        let design = design.split("[[scenario]]").next().unwrap();
        let drawn = objective_at_start(&dir, design);
        let told = format!("{design}\n[[scenario]]\nname = \"told\"\n{keys}\n");
        let mut found = vec![objective_at_start(&dir, &told)];
        let scene = dir.text("p1.toml");
        if let Some(numbers) = keys.strip_prefix("numbers = ") {
            dir.write("p1.toml", &format!("numbers = {numbers}\n{scene}"));
            found.push(objective_at_start(&dir, design));
        }
        let by_hand = self.by_hand.iter().fold(scene, |text, (old, new)| {
            assert!(text.contains(old), "{old}");
            text.replace(old, new)
        });
        dir.write("p1.toml", &by_hand);
        let expected = objective_at_start(&dir, design);
        for found in found {
            assert!((found / expected - 1.0).abs() < 1e-9, "{keys}: {found} and {expected}");
        }
        assert!((drawn / expected - 1.0).abs() > 1e-5, "{keys} changes nothing: {expected}");
    }
}

#[test]
fn scenarios_and_numbers_are_scenes_that_are_changed_by_hand() {
    TOLD.par_iter().for_each(Told::check);
}

/// Walls that are off are those of another mesh, and the objective is the weighted mean.
#[test]
fn an_objective_is_the_mean_of_its_scenarios() {
    let dir = workdir("");
    let one = chamber::DESIGN.replace("sim.toml", "other.toml");
    dir.solver("-q optimize design.toml -o out").assert_good();
    let line = first_line(&dir, "out");
    let total = |name: &str| line["scenarios"][name]["objective"].as_f64().unwrap();
    move_walls(&dir, -WALL);
    dir.write("other.toml", &dir.text("p1.toml").replace("body.msh", "moved.msh"));
    let expected = objective_at_start(&dir, &one);
    assert!((total("thin") / expected - 1.0).abs() < 1e-9, "{} and {expected}", total("thin"));
    let of = |name: &str, term: &str| line["scenarios"][name]["terms"][term].as_f64().unwrap();
    assert_eq!(of("less", "smooth"), 0.0);
    assert!(of("as drawn", "smooth") > 0.0);
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
