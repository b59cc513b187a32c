//! First time steps of published scenes, by the programs as users run them.

use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use solver::forward::Timings;
use tests::published::FOLDER;
use tests::shared;
use tests::workdir::program;

use crate::row::{Row, Seconds, Work};

/// Seconds and peak memory [GB] of PolyFEM (661588e8, Pardiso, 2 threads) for the
/// nonlinear solves of the same steps: name, scene, steps.
const SCENES: [(&str, &str, usize, f64, f64); 2] = [
    ("gripper", "gripper_bellows/state_gripper_bellows.json", 3, 3.0 * 76.5, 7.1),
    ("worm", "worm/state_worm.json", 5, 12.2 + 154.0 + 27.1 + 18.3 + 13.7, 3.0),
];
/// As in those runs.
const TOLERANCE: &str = "\n[solver]\nrelative_tolerance = 1e-7\n";
/// Runs of one scene.
const RUNS: usize = 3;

/// The rows whose keys are wanted.
///
/// # Errors
/// When a scene is at hand and cannot be run.
pub fn rows(wanted: &dyn Fn(&str) -> bool) -> Result<Vec<(Row, Timings)>> {
    let mut rows = Vec::new();
    for (name, scene, steps, polyfem_s, polyfem_gb) in SCENES {
        if !wanted(&format!("motion/{name}")) {
            continue;
        }
        let Some(path) = shared(&format!("{FOLDER}/{scene}")) else { continue };
        eprintln!("moving {name}");
        let folder = tempfile::tempdir()?;
        let solver = |arguments: &[&str]| -> Result<()> {
            let output = Command::new(program("solver"))
                .args(arguments)
                .current_dir(folder.path())
                .output()
                .context("solver")?;
            let stderr = String::from_utf8_lossy(&output.stderr);
            ensure!(output.status.success(), "solver {arguments:?}: {stderr}");
            Ok(())
        };
        solver(&["import", &path.to_string_lossy(), "-o", "scene"])?;
        let file = folder.path().join("scene/sim.toml");
        std::fs::write(&file, std::fs::read_to_string(&file)? + TOLERANCE)?;
        let n = steps.to_string();
        let run = |threads: &[&str]| -> Result<Value> {
            let scene = ["simulate", "scene/sim.toml", "-o", "out", "--final-only", "--steps", &n];
            solver(&[&scene, threads].concat())?;
            let text = std::fs::read_to_string(folder.path().join("out/report.json"))?;
            Ok(serde_json::from_str(&text)?)
        };
        let time = |report: &Value| report["equilibrium_s"].as_f64().context("equilibrium_s");
        let (mut seconds, mut peaks, mut last) = (Vec::new(), Vec::new(), Value::Null);
        for _ in 0..RUNS {
            last = run(&[])?;
            seconds.push(time(&last)?);
            peaks.push(last["peak_rss_mb"].as_f64().context("peak_rss_mb")?);
        }
        let one_thread_s = Some(time(&run(&["--threads", "1"])?)?);
        let seconds = Seconds::new(seconds);
        let peak = peaks.into_iter().fold(0.0, f64::max);
        let dofs = last["dofs"].as_u64().context("dofs")? as usize;
        let timings: Timings = serde_json::from_value(last["timings"].clone())?;
        let row = Row {
            one_thread_s,
            what: "motion".to_owned(),
            body: name.to_owned(),
            dofs: Some(dofs),
            seconds,
            work: Work::Dofs((dofs * steps) as f64),
            peak_mb: Some(peak),
            beside: format!(
                "{steps} steps, {} iterations; PolyFEM {polyfem_s:.0} s, {polyfem_gb} GB: {:.1} × as \
                 fast, {:.2} of the memory; collision detection {:.1} % of it",
                last["newton_iterations"],
                polyfem_s / seconds.median,
                peak * 1.048_576e-3 / polyfem_gb,
                100.0 * timings.collision.wall_s / seconds.median
            ),
        };
        rows.push((row, timings));
    }
    Ok(rows)
}
