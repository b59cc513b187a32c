//! Limits of pressures and paths by arc length, by the program, on a block with a chamber.

use serde_json::Value;
use tests::chamber::{self, PRESSURE};
use tests::workdir::Workdir;

/// The scene of the chamber with more tables.
fn with(more: &str) -> Workdir {
    let dir = chamber::workdir();
    let text = dir.text("sim.toml");
    dir.write("edge.toml", &format!("{text}\n{more}"));
    dir
}

/// A thick block bears more than is asked for, and its state at the end is stable.
#[test]
fn a_block_is_stable_to_what_is_asked_for() {
    let dir = with("[limit]\nmost = 1.3\n[solver]\nstability = true\n");
    dir.solver("simulate edge.toml -o out").assert_says(&["stable to 1.3"]);
    let report = dir.json("out/report.json");
    assert_eq!(report["limit"]["status"], "stable-to");
    assert_eq!(report["limit"]["factor"], Value::Null);
    assert_eq!(report["limit"]["stable_to"], 1.3);
    assert_eq!(report["stability"]["negative_eigenvalues"], 0);
    let softer = report["stability"]["stiffness_over_rest"].as_f64().unwrap();
    assert!((0.1..2.0).contains(&softer), "{softer}");
}

/// Along the arc length the same states are passed as along the load.
#[test]
fn a_path_comes_to_the_full_load() {
    let dir = with("[solver]\nfollow = \"arc-length\"\n");
    dir.solver("simulate edge.toml -o out").assert_good();
    dir.solver("simulate sim.toml -o load").assert_good();
    let volume = |folder: &str| {
        let report = dir.json(&format!("{folder}/report.json"));
        report["chambers"]["cavity"]["volume"].as_f64().unwrap()
    };
    assert!((volume("out") / volume("load") - 1.0).abs() < 1e-9);
    let lines = dir.lines("out/steps.jsonl");
    assert!(lines.len() > 2, "{lines:?}");
    let arcs: Vec<f64> =
        lines.iter().map(|line| line["path"]["arc_length"].as_f64().unwrap()).collect();
    assert!(arcs.windows(2).all(|pair| pair[0] < pair[1]), "{arcs:?}");
    for line in &lines {
        let pressure = line["chambers"]["cavity"]["pressure"].as_f64().unwrap();
        let load = line["load"].as_f64().unwrap();
        assert!((pressure - load * PRESSURE).abs() < 1e-9 * PRESSURE);
        assert_eq!(line["path"]["stability"]["negative_eigenvalues"], 0);
    }
}

/// What was asked for and not reached is no result, unless the path is what is asked for.
#[test]
fn a_path_that_ends_early_is_not_usable() {
    let dir = with("[solver]\nfollow = \"arc-length\"\npath_states = 2\n");
    dir.solver("simulate edge.toml -o out")
        .assert_refused(1, &["full load", "path_states", "path_only"]);
    let report = dir.json("out/report.json");
    assert_eq!(
        (&report["usable"], &report["status"]),
        (&false.into(), &"full load not reached".into())
    );
    let load = report["load_reached"].as_f64().unwrap();
    assert!((0.01..0.5).contains(&load), "{load}");
    let alone = dir.text("edge.toml").replace("path_states", "path_only = true\npath_states");
    dir.write("alone.toml", &alone);
    let report = dir.report("simulate alone.toml -o alone");
    assert_eq!((&report["usable"], &report["load_reached"]), (&true.into(), &load.into()));
}

/// The factors of the limit and of the burst change with the modulus in proportion, as pressure is the only load; by one
/// number of the law they and the slope are compared with two other runs.
#[test]
fn limits_have_error_bars() {
    let dir = chamber::near_its_edges();
    let scene = dir.text("p1.toml");
    let uncertain = "\n[uncertainty]\nmodulus = 0.1\nnumbers = { \"material.body.c1\" = 1e3 }\n";
    let edges = |c1: f64, more: &str| {
        dir.write("other.toml", &(scene.replace("c1 = 55e3", &format!("c1 = {c1}")) + more));
        let run = dir.solver("simulate other.toml -o other --restart");
        run.assert_good();
        (dir.json("other/report.json")["limit"].clone(), run.stderr)
    };
    let (found, said) = edges(55e3, uncertain);
    let (more, less) = (edges(55.05e3, "").0, edges(54.95e3, "").0);
    for key in ["factor", "burst", "slope"] {
        let number = |report: &Value| report[key].as_f64().unwrap();
        let bars = &found["error_bars"][key];
        assert_eq!(bars["value"], found[key]);
        let by = |of: &str| {
            let all = bars["bars"].as_array().unwrap();
            all.iter().find(|bar| bar["of"] == of).unwrap()["derivative"].as_f64().unwrap()
        };
        let (by_modulus, by_c1) = (by("modulus"), by("material.body.c1"));
        if key != "slope" {
            assert!((by_modulus / number(&found) - 1.0).abs() < 1e-6, "{by_modulus} {found}");
        }
        let slope = (number(&more) - number(&less)) / 100.0;
        assert!((by_c1 / slope - 1.0).abs() < 1e-4, "{key} {by_c1} {slope}");
        assert!(said.contains(&format!("limit: {key} ")), "{said}");
    }
}
