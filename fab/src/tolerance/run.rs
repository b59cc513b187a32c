//! The program `solver`, run on a body and read back.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use program::{Change, Process};
use reports::Simulation;

use super::offset::Cut;

/// How to simulate a body.
#[derive(Clone, Debug)]
pub struct Solver {
    /// The program.
    pub program: PathBuf,
    /// The scene.
    pub scene: PathBuf,
    /// The body of the scene, if it has several.
    pub body: Option<String>,
    /// Other values of the scene.
    pub changes: Vec<Change>,
}

impl Solver {
    /// Simulates `mesh` into `folder`.
    pub fn run(&self, mesh: &Path, folder: &Path) -> Result<Run> {
        let mesh = match &self.body {
            Some(body) => format!("{body}={}", mesh.display()),
            None => mesh.display().to_string(),
        };
        let mut command = Command::new(&self.program);
        command.arg("simulate").arg(&self.scene).args(["--mesh", &mesh, "-o"]).arg(folder);
        for change in &self.changes {
            command.arg("--set").arg(change.to_string());
        }
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let process = Process::spawn(&mut command).with_context(|| {
            format!("{}: cannot be run; give its place with --solver", self.program.display())
        })?;
        let mut said = Vec::new();
        if let Some(mut stderr) = process.take_stderr() {
            stderr.read_to_end(&mut said)?;
        }
        let (status, said) = (process.wait()?, String::from_utf8_lossy(&said));
        ensure!(status.success(), "solver simulate ended with {status}:\n{said}");
        read(&folder.join("report.json"))
    }
}

/// What a simulation found.
pub struct Run {
    /// Name, unit and value of every response.
    pub responses: Vec<(String, &'static str, f64)>,
    /// Planes of symmetry that cut the body.
    pub cuts: Vec<Cut>,
}

fn read(path: &Path) -> Result<Run> {
    let text = mesh::io::read_text(path)?;
    let report: Simulation =
        serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    let end = report.end.filter(|_| report.usable);
    let end = end.with_context(|| format!("{}: the result may not be used", path.display()))?;
    let mut found = Vec::new();
    for (name, chamber) in &end.chambers {
        found.push((format!("chambers.{name}.volume"), "m³", chamber.volume));
        found.push((format!("chambers.{name}.pressure"), "Pa", chamber.pressure));
    }
    for (name, tag) in &end.tags {
        found.push((format!("tags.{name}.mean_displacement"), "m", tag.mean_displacement));
        found.push((format!("tags.{name}.max_displacement"), "m", tag.max_displacement));
    }
    if let Some(limit) = &end.limit {
        // where it balloons no earlier than it was asked for, that is a bound
        found.push(("limit.factor".to_owned(), "1", limit.factor.unwrap_or(limit.stable_to)));
    }
    let cuts = report.symmetry.unwrap_or_default();
    let cuts = cuts.iter().map(|plane| Cut::new(&plane.axis, plane.level));
    let cuts = cuts.collect::<Option<_>>();
    let cuts = cuts.with_context(|| format!("{}: a plane across no axis", path.display()))?;
    Ok(Run { responses: found, cuts })
}
