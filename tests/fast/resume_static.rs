//! A static simulation that is killed continues after its last load steps.

use serde_json::Value;
use tests::chamber;
use tests::kills::killed;
use tests::workdir::Workdir;

const COMMAND: &str = "--threads 2 -q simulate sim.toml -o out";

/// A static scene that takes some seconds: its load comes in many small steps.
fn workdir() -> Workdir {
    let dir = chamber::workdir();
    let slow = "[solver]\nlargest_load_step = 0.004\n\n[material]";
    dir.write(
        "sim.toml",
        &format!("{}{}", chamber::SIM.replace("[material]", slow), chamber::PROBES),
    );
    dir
}

fn probes(line: &Value) -> Vec<f64> {
    line["probes"].as_object().unwrap().values().map(|v| v.as_f64().unwrap()).collect()
}

fn work(line: &Value) -> f64 {
    line["work_of_loads"].as_f64().unwrap()
}

/// Intermediate load steps need only be solved roughly, so that they agree roughly, and so does
/// the work of the loads, which is a sum over all of them.
#[test]
fn killed_between_load_steps() {
    let undisturbed = workdir();
    undisturbed.solver(COMMAND).assert_good();
    let dir = workdir();
    let checkpoint = dir.path("out/checkpoint.json");
    assert!(killed(dir.command(COMMAND), || checkpoint.exists()), "over before it was killed");
    let made = dir.lines("out/steps.jsonl").len();
    assert!(
        made > 0 && dir.path("out/step_000.vtu").exists() && !dir.path("out/report.json").exists()
    );
    let command = COMMAND.replace("-q ", "");
    let run = dir.solver(&command);
    run.assert_good();
    let continued = run.stderr.split("continuing after ").nth(1).expect("said so");
    let kept: usize = continued.split(' ').next().unwrap().parse().unwrap();
    assert!(kept > 0 && kept <= made, "{kept} of {made}");
    let (found, expected) = (dir.lines("out/steps.jsonl"), undisturbed.lines("out/steps.jsonl"));
    assert_eq!(found.len(), expected.len());
    assert_eq!(found[..kept], expected[..kept], "made before it was killed, by the same steps");
    for (i, (line, expected)) in found.iter().zip(&expected).enumerate() {
        assert_eq!(line["t"], expected["t"]);
        let tolerance = if i + 1 == found.len() { 1e-9 } else { 1e-5 };
        let (a, b) = (work(line), work(expected));
        assert!((a - b).abs() <= 1e-5 * b.abs(), "work in load step {i}: {a} and {b}");
        for (a, b) in probes(line).into_iter().zip(probes(expected)) {
            assert!((a - b).abs() <= tolerance * b.abs(), "load step {i}: {a} and {b}");
        }
    }
    let files = dir.files("out");
    assert!(!files.contains(&"checkpoint.json".to_owned()), "{files:?}");
    assert_eq!(files.iter().filter(|f| f.starts_with("step_")).count(), found.len(), "{files:?}");
    assert_eq!(dir.json("out/report.json")["status"], "ok");
    assert_eq!(dir.json("out/report.json")["steps"].as_array().unwrap().len(), found.len());
}
