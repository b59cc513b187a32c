//! The folder of an optimisation: what a run before has left there.

use std::path::Path;

use anyhow::{Context, Result};
use reports::{Ended, LevelEnd};
use serde::Deserialize;

use crate::optimize::Checkpoint;
use crate::report::results;

/// Whether the folder holds an optimisation of other inputs that is finished or
/// has no result. Any other is removed with --restart only.
pub(super) fn outdated(folder: &Path, inputs: &str) -> Result<bool> {
    let finished = folder.join("report.json").exists() && !failed(folder)?;
    Ok(Checkpoint::read(folder)?
        .is_some_and(|c| c.inputs != inputs && (finished || c.history == 0)))
}

/// What is read of a report.
#[derive(Deserialize)]
struct Usable {
    usable: bool,
}

/// Whether the report in the folder is that of a start without equilibrium.
pub(super) fn failed(folder: &Path) -> Result<bool> {
    let path = folder.join("report.json");
    if !path.exists() {
        return Ok(false);
    }
    let report = serde_json::from_str::<Usable>(&mesh::io::read_own_text(&path)?);
    Ok(!report.with_context(|| path.display().to_string())?.usable)
}

/// Whether the report in the folder is of a design whose next level could not begin: to try it again would lose it.
pub(super) fn is_kept_before_a_level(folder: &Path) -> Result<bool> {
    let path = folder.join("report.json");
    if !path.exists() || failed(folder)? {
        return Ok(false);
    }
    let report = serde_json::from_str::<Levels>(&mesh::io::read_own_text(&path)?);
    let levels = report.with_context(|| path.display().to_string())?.levels;
    Ok(levels.last().is_some_and(|end| end.ending == Ended::NoEquilibrium))
}

/// What is read of a report for that; reports of programs before have no levels.
#[derive(Deserialize)]
struct Levels {
    #[serde(default)]
    levels: Vec<LevelEnd>,
}

/// Removes the report of a failure once the run continues.
pub(super) fn forget_failure(folder: &Path) -> Result<()> {
    if failed(folder)? {
        remove(folder, &["report.json", results::FAILED])?;
    }
    Ok(())
}

/// Removes what a run without a first evaluation cannot be continued from.
pub(super) fn forget_start(folder: &Path) -> Result<()> {
    if Checkpoint::read(folder)?.is_none_or(|c| c.history > 0) {
        return Ok(());
    }
    remove(folder, &["checkpoint.json", "history.jsonl"])?;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.starts_with("level-") && name.ends_with(".msh") {
            remove(folder, &[&name])?;
        }
    }
    Ok(())
}

pub(super) fn forget(folder: &Path) -> Result<()> {
    let names = [
        "checkpoint.json",
        "history.jsonl",
        "report.json",
        "result.vtu",
        "pressures.toml",
        "parameters.toml",
    ];
    remove(folder, &names)?;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let design = ["design.", "latest.", "castable.", "remeshed-"]
            .iter()
            .any(|first| name.starts_with(first));
        let design = design && name.ends_with(".msh");
        if design || (name.starts_with("run-") && name.ends_with(".npy")) {
            remove(folder, &[&name])?;
        }
    }
    remove(folder, &[results::FAILED])
}

pub(super) fn remove(folder: &Path, names: &[&str]) -> Result<()> {
    for name in names {
        mesh::io::remove_output(&folder.join(name))?;
    }
    Ok(())
}
