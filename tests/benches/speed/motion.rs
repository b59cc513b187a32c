//! Runs of several steps, by the programs as users run them: first steps of published
//! scenes, and a finger of ours.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use criterion::Throughput;
use serde_json::Value;
use tests::published::FOLDER;
use tests::shared;
use tests::workdir::program;

use crate::{Bench, finger};

struct Case {
    body: &'static str,
    steps: usize,
    /// Writes `scene/sim.toml` into a folder; false where a published scene is not at hand.
    write: fn(&Path) -> Result<bool>,
}

const CASES: [Case; 3] = [
    Case {
        body: "gripper",
        steps: 3,
        write: |folder| import("gripper_bellows/state_gripper_bellows.json", folder),
    },
    Case { body: "worm", steps: 5, write: |folder| import("worm/state_worm.json", folder) },
    Case { body: "finger", steps: finger::STEPS, write: finger::write },
];

/// All that is asked for, without the time to read and write files.
pub fn time(bench: &mut Bench) -> Result<()> {
    for Case { body, steps, write } in &CASES {
        let folder = tempfile::tempdir()?;
        if !bench.wants("motion", body) || !write(folder.path())? {
            continue;
        }
        let run = || -> Result<f64> {
            let steps = steps.to_string();
            let run =
                ["simulate", "scene/sim.toml", "-o", "out", "--final-only", "--steps", &steps];
            solver(folder.path(), &run)?;
            let text = std::fs::read_to_string(folder.path().join("out/report.json"))?;
            serde_json::from_str::<Value>(&text)?["equilibrium_s"].as_f64().context("equilibrium_s")
        };
        bench.group(["motion", body], Throughput::Elements(*steps as u64), |group| {
            group.bench_function(*body, |b| {
                b.iter_custom(|times| {
                    let runs = (0..times).map(|_| run().expect("as the scene is written"));
                    Duration::from_secs_f64(runs.sum())
                });
            });
        });
    }
    Ok(())
}

fn solver(folder: &Path, arguments: &[&str]) -> Result<()> {
    let output = Command::new(program("solver"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .context("solver")?;
    let stderr = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "solver {arguments:?}: {stderr}");
    Ok(())
}

/// A published scene, to the tolerance of PolyFEM's runs.
fn import(scene: &str, folder: &Path) -> Result<bool> {
    let Some(path) = shared(&format!("{FOLDER}/{scene}")) else { return Ok(false) };
    solver(folder, &["import", &path.to_string_lossy(), "-o", "scene"])?;
    let file = folder.join("scene/sim.toml");
    std::fs::write(&file, std::fs::read_to_string(&file)? + TOLERANCE)?;
    Ok(true)
}

const TOLERANCE: &str = "\n[solver]\nrelative_tolerance = 1e-7\n";
