//! Runs that are kept for comparison.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use tests::workdir::repository;

use crate::row::Row;
use crate::solves::Solve;

/// A full run of the benchmarks.
#[derive(Serialize, Deserialize)]
pub struct Stored {
    /// Processor and number of threads.
    pub machine: String,
    /// Commit, with `+` where files had changed since.
    pub commit: String,
    /// Begin of the run, UTC.
    pub date: String,
    /// Runnable programs of the last minute, before the run began.
    pub load: String,
    /// Lines of the table.
    pub rows: Vec<Row>,
    /// Whole solves in detail.
    pub solves: Vec<Solve>,
}

impl Stored {
    /// This run, with nothing measured yet.
    pub fn begin() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let of_system = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
        let info = of_system("/proc/cpuinfo");
        let model = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
        let model = model.map_or("unknown processor", |m| m.1);
        let host = of_system("/proc/sys/kernel/hostname");
        let changed = !said("git", &["status", "--porcelain", "--untracked-files=no"]).is_empty();
        let commit = said("git", &["rev-parse", "--short", "HEAD"]);
        Self {
            machine: format!("{}, {model}, {threads} threads", host.trim()),
            commit: commit + if changed { "+" } else { "" },
            date: said("date", &["-u", "+%Y-%m-%d %H:%M"]),
            load: of_system("/proc/loadavg").split(' ').next().unwrap_or_default().to_owned(),
            rows: Vec::new(),
            solves: Vec::new(),
        }
    }

    /// All full runs that are kept in a file, one in each line, the latest last.
    pub fn history(path: &Path) -> Result<Vec<Self>> {
        if !path.exists() {
            return Ok(Vec::new());
        }
        let text = read(path)?;
        let line = |(i, line): (usize, &str)| {
            serde_json::from_str(line).with_context(|| {
                let (path, line) = (path.display(), i + 1);
                format!(
                    "{path}: line {line} is not as this version writes it; remove it to continue"
                )
            })
        };
        text.lines().enumerate().map(line).collect()
    }

    /// Adds this run to the file.
    pub fn keep(&self, path: &Path) -> Result<()> {
        let before = if path.exists() { read(path)? } else { String::new() };
        let line = serde_json::to_string(self)?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        mesh::io::write_atomic(path, |out| writeln!(out, "{before}{line}"))?;
        Ok(())
    }

    /// One line about when and where.
    pub fn title(&self) -> String {
        let Self { machine, commit, date, load, .. } = self;
        format!("{date} UTC, commit {commit}, {machine}, load before {load}")
    }
}

/// The text of a file. It is no input: a run adds to it.
fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| path.display().to_string())
}

/// What a program prints in the repository, or nothing where it cannot.
fn said(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).current_dir(repository()).output();
    output.map_or(String::new(), |o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
}
