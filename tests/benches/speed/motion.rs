//! Runs of several steps, by the programs as users run them: first steps of published
//! scenes, and a finger of ours.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use mechanics::forward::Timings;
use mesh::io::write_tets;
use serde_json::Value;
use tests::published::{FOLDER, gripper};
use tests::shared;
use tests::workdir::program;

use crate::finger;
use crate::row::{Row, Seconds, Work};

struct Case {
    what: &'static str,
    body: &'static str,
    steps: usize,
    /// Seconds and peak memory [GB] of PolyFEM (661588e8, Pardiso, 2 threads) for the
    /// nonlinear solves of the same steps, where it was run.
    polyfem: Option<(f64, f64)>,
    /// On all threads; one more is made on one thread if there are several.
    runs: usize,
    /// Writes `scene/sim.toml` into a folder; false where a published scene is not at hand.
    write: fn(&Path) -> Result<bool>,
}

const CASES: [Case; 4] = [
    Case {
        what: "motion",
        body: "gripper",
        steps: 3,
        polyfem: Some((3.0 * 76.5, 7.1)),
        runs: 3,
        write: |folder| import("gripper_bellows/state_gripper_bellows.json", folder),
    },
    Case {
        what: "motion",
        body: "worm",
        steps: 5,
        polyfem: Some((12.2 + 154.0 + 27.1 + 18.3 + 13.7, 3.0)),
        runs: 3,
        write: |folder| import("worm/state_worm.json", folder),
    },
    Case {
        what: "quasistatic",
        body: "gripper",
        steps: 5,
        // the memory is that of its static solve of the same body
        polyfem: Some((656.0, 6.3)),
        runs: 1,
        write: quasistatic_gripper,
    },
    Case {
        what: "motion",
        body: "finger",
        steps: finger::STEPS,
        polyfem: None,
        runs: 3,
        write: finger::write,
    },
];

/// The rows whose keys are wanted.
pub fn rows(wanted: &dyn Fn(&str) -> bool) -> Result<Vec<(Row, Timings)>> {
    let mut rows = Vec::new();
    for case in &CASES {
        if wanted(&format!("{}/{}", case.what, case.body)) {
            rows.extend(case.measure()?);
        }
    }
    Ok(rows)
}

impl Case {
    fn measure(&self) -> Result<Option<(Row, Timings)>> {
        let folder = tempfile::tempdir()?;
        if !(self.write)(folder.path())? {
            return Ok(None);
        }
        eprintln!("{} {}", self.what, self.body);
        let time = |report: &Value| report["equilibrium_s"].as_f64().context("equilibrium_s");
        let (mut seconds, mut peaks, mut last) = (Vec::new(), Vec::new(), Value::Null);
        for _ in 0..self.runs {
            last = self.run(folder.path(), &[])?;
            seconds.push(time(&last)?);
            peaks.push(last["peak_rss_mb"].as_f64().context("peak_rss_mb")?);
        }
        let one_thread_s = (self.runs > 1)
            .then(|| time(&self.run(folder.path(), &["--threads", "1"])?))
            .transpose()?;
        let dofs = last["dofs"].as_u64().context("dofs")? as usize;
        let timings: Timings = serde_json::from_value(last["timings"].clone())?;
        let (seconds, peak_mb) = (Seconds::new(seconds), peaks.into_iter().fold(0.0, f64::max));
        let row = Row {
            one_thread_s,
            what: self.what.to_owned(),
            body: self.body.to_owned(),
            dofs: Some(dofs),
            seconds,
            work: Work::Dofs((dofs * self.steps) as f64),
            peak_mb: Some(peak_mb),
            beside: self.beside(&last, &timings, seconds.median, peak_mb),
        };
        Ok(Some((row, timings)))
    }

    fn run(&self, folder: &Path, threads: &[&str]) -> Result<Value> {
        let steps = self.steps.to_string();
        let run = ["simulate", "scene/sim.toml", "-o", "out", "--final-only", "--steps", &steps];
        solver(folder, &[&run, threads].concat())?;
        Ok(serde_json::from_str(&std::fs::read_to_string(folder.join("out/report.json"))?)?)
    }

    fn beside(&self, report: &Value, timings: &Timings, seconds: f64, peak_mb: f64) -> String {
        let mut text = format!(
            "{} steps, {} iterations, {} factorisations of which {} failed; collision detection \
             {:.1} % of it",
            self.steps,
            report["newton_iterations"],
            timings.factorizations,
            timings.failed_factorizations,
            100.0 * timings.collision.wall_s / seconds
        );
        let step = report["steps"].as_array().and_then(|steps| steps.last());
        let force = step.and_then(|step| step.pointer("/collisions/contact/0/magnitude"));
        if let Some(force) = force.and_then(Value::as_f64) {
            text += &format!("; contact of {force:.3} N");
        }
        if let Some((polyfem_s, polyfem_gb)) = self.polyfem {
            text += &format!(
                "; PolyFEM {polyfem_s:.0} s, {polyfem_gb} GB: {:.1} × as fast, {:.2} of the memory",
                polyfem_s / seconds,
                peak_mb * 1.048_576e-3 / polyfem_gb,
            );
        }
        text
    }
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

/// The published gripper without its cylinder, to 5, 10, 20, 30 and 40 kPa.
fn quasistatic_gripper(folder: &Path) -> Result<bool> {
    let Some(body) = gripper() else { return Ok(false) };
    let scene = folder.join("scene");
    std::fs::create_dir_all(&scene)?;
    write_tets(&scene.join("body.msh"), &body.mesh, &body.tags)?;
    let text = "mesh = \"body.msh\"\ndegree = 2\n\
         [material]\nkind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\nd1 = 1e6\n\
         [[fixed]]\non = \"fixed\"\n\
         [[chamber]]\non = \"cavity\"\npressure = \"40e3*t\"\n\
         [time]\nat = [0.125, 0.25, 0.5, 0.75, 1.0]\nmethod = \"quasistatic\"\n";
    std::fs::write(scene.join("sim.toml"), text.to_owned() + TOLERANCE)?;
    Ok(true)
}
