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

#[track_caller]
fn refused(more: &str, words: &[&str]) {
    let dir = with(more);
    dir.solver("simulate edge.toml -o out").assert_refused(2, words);
    assert!(!dir.path("out/report.json").exists());
}

/// A thick block bears more than is asked for, and its state at the end is stable.
#[test]
fn a_block_is_stable_to_what_is_asked_for() {
    let dir = with("[limit]\nmost = 1.3\n[solver]\nstability = true\n");
    let run = dir.solver("simulate edge.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("stable to 1.3"), "{}", run.stderr);
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
    let text = dir.text("out/steps.jsonl");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() > 2, "{text}");
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

#[test]
fn what_has_no_limit_or_path_is_refused() {
    refused("[limit]\non = [\"top\"]\n", &["[limit]", "top", "cavity"]);
    refused("[limit]\nmost = 0.5\n", &["most", "above 1"]);
    refused(
        "[limit]\n[time]\nend = 1\nsteps = 2\nmethod = \"quasistatic\"\n",
        &["[limit]", "[time]"],
    );
    refused("[solver]\npath_states = 3\n", &["path_states", "arc-length"]);
    refused("[solver]\nfollow = \"arc-length\"\npath_states = 0\n", &["path_states", "one state"]);
}
