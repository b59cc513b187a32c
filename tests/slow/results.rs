//! The numbers of finished designs, `pipelines/*/results.json`: their kept bodies are simulated again.
//!
//! ```json
//! {
//!   "machine": "…", "version": "…", "date": "…",
//!   "runs": [{
//!     "name": "designed",
//!     "scene": "sim.toml",
//!     "set": ["time.end=4", "time.steps=80"],
//!     "mesh": {"worm": "designed.msh.gz"},
//!     "tolerance": 1e-2,
//!     "values": {"/probes/way/value": 5.1e-3},
//!     "extremes": {"/probes/nose": [-0.3, 0.1]}
//!   }]
//! }
//! ```
//!
//! `set` and `mesh` may be missing. `values` are JSON pointers into report.json, `extremes` the least and the largest of a pointer into
//! its steps; they may be off by the tolerance times the largest of the numbers beside them.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tests::workdir::{Workdir, program, repository};

use crate::run;

fn number(at: &Value, pointer: &str) -> f64 {
    at.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {pointer}"))
}

/// What differs from the kept numbers of a run, one line each.
fn differences(kept: &Value, folder: &Path) -> Vec<String> {
    let dir = Workdir::new();
    let mut simulate = Command::new(program("solver"));
    let scene = folder.join(kept["scene"].as_str().unwrap());
    simulate.args(["-q", "simulate"]).arg(scene).arg("--final-only").arg("-o").arg(dir.path("out"));
    for set in kept["set"].as_array().into_iter().flatten() {
        simulate.args(["--set", set.as_str().unwrap()]);
    }
    for (body, file) in kept["mesh"].as_object().into_iter().flatten() {
        let file = folder.join(file.as_str().unwrap());
        simulate.arg("--mesh").arg(format!("{body}={}", file.display()));
    }
    run(&mut simulate);
    let report = dir.json("out/report.json");
    let steps = report["steps"].as_array().unwrap();
    let tolerance = kept["tolerance"].as_f64().unwrap();

    let mut compared = Vec::new();
    for (pointer, value) in kept["values"].as_object().into_iter().flatten() {
        let (was, is) = (value.as_f64().unwrap(), number(&report, pointer));
        compared.push((pointer.clone(), was, is, was.abs()));
    }
    for (pointer, value) in kept["extremes"].as_object().into_iter().flatten() {
        let all: Vec<f64> = steps.iter().map(|step| number(step, pointer)).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let [low, high] = [0, 1].map(|i| value[i].as_f64().unwrap());
        let scale = low.abs().max(high.abs());
        compared.push((format!("least {pointer}"), low, least, scale));
        compared.push((format!("largest {pointer}"), high, largest, scale));
    }
    assert!(!compared.is_empty(), "{kept}: nothing to compare");
    let name = format!("{}, {}", folder.display(), kept["name"].as_str().unwrap());
    let mut wrong = Vec::new();
    for (what, was, is, scale) in compared {
        let line = format!("{name}: {what}: {was:.6e} in results.json, {is:.6e} now");
        eprintln!("{line}");
        if (was - is).abs() > tolerance * scale {
            wrong.push(line);
        }
    }
    wrong
}

#[test]
#[ignore = "simulates all kept designs in minutes: make check-results"]
fn results_of_designs_are_found_again() {
    let mut wrong = Vec::new();
    let mut found = 0;
    for entry in fs::read_dir(repository().join("pipelines")).unwrap() {
        let folder = entry.unwrap().path();
        let Ok(text) = fs::read_to_string(folder.join("results.json")) else { continue };
        let results: Value = serde_json::from_str(&text).unwrap();
        for kept in results["runs"].as_array().unwrap() {
            wrong.extend(differences(kept, &folder));
            found += 1;
        }
    }
    assert!(found > 0, "no results.json");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
