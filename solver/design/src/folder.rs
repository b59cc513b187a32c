//! The folder of an optimisation: what a run before has left there.

use std::path::Path;

use anyhow::{Context, Result};
use reports::{Ended, Optimization};
use run::report::results;

use super::Checkpoint;

/// What a run without a first evaluation leaves, from which nothing can be continued.
const OF_START: [&str; 2] = ["checkpoint.json", "history.jsonl"];
/// What else an optimisation writes.
const OF_DESIGN: [&str; 5] =
    ["report.json", "result.vtu", "pressures.toml", "parameters.toml", results::FAILED];
/// Beginnings of the names of meshes that it writes. Meshes at the start of levels have other names.
const MESHES: [&str; 4] = ["design.", "latest.", "castable.", "remeshed-"];

/// The report of a design in the folder, if there is one; those of other commands are none.
pub fn report(folder: &Path) -> Result<Option<Optimization>> {
    let path = folder.join("report.json");
    if !path.exists() {
        return Ok(None);
    }
    let report = serde_json::from_str(&mesh::io::read_own_text(&path)?);
    let report: serde_json::Value = report.with_context(|| path.display().to_string())?;
    Ok(serde_json::from_value(report).ok())
}

/// Makes a folder ready for the optimisation of some inputs, and says whether there is anything to do. What is finished, or
/// has no result, is removed where it is of other inputs; all else with `restart` only.
pub fn prepare(folder: &Path, inputs: &str, restart: bool) -> Result<bool> {
    let mut report = report(folder)?;
    let is_finished = report.as_ref().is_some_and(|report| report.usable);
    let is_outdated = |c: &Checkpoint| c.inputs != inputs && (is_finished || c.history == 0);
    if restart || Checkpoint::read(folder)?.as_ref().is_some_and(is_outdated) {
        if is_finished {
            log::warn!("{}: the finished design there is replaced", folder.display());
        }
        forget(folder)?;
        report = None;
    }
    let Some(report) = report else { return Ok(true) };
    if !report.usable {
        // once the run continues
        remove(folder, |name| ["report.json", results::FAILED].contains(&name))?;
    }
    let levels = report.designed.filter(|_| report.usable).map(|designed| designed.levels);
    // to try the level again that could not begin would lose what was kept
    let is_kept =
        levels.iter().flatten().last().is_some_and(|end| end.ending == Ended::NoEquilibrium);
    if is_kept {
        log::info!("{}: is finished, before a level that cannot begin", folder.display());
    }
    Ok(!is_kept)
}

/// Removes what a run without a first evaluation cannot be continued from.
pub(super) fn forget_start(folder: &Path) -> Result<()> {
    if Checkpoint::read(folder)?.is_none_or(|c| c.history > 0) {
        return Ok(());
    }
    let is_level = |name: &str| name.starts_with("level-") && name.ends_with(".msh");
    remove(folder, |name| OF_START.contains(&name) || is_level(name))
}

/// Removes all that an optimisation has written but the meshes that its levels begin with.
fn forget(folder: &Path) -> Result<()> {
    remove(folder, |name| {
        OF_START.contains(&name)
            || OF_DESIGN.contains(&name)
            || name.ends_with(".msh") && MESHES.iter().any(|first| name.starts_with(first))
            || name.starts_with("run-") && name.ends_with(".npy")
    })
}

/// Removes the files whose names are these.
fn remove(folder: &Path, is_one: impl Fn(&str) -> bool) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| is_one(&name.to_string_lossy())) {
            mesh::io::remove_output(&path)?;
        }
    }
    Ok(())
}

/// Copies what a finished design continues from to an empty folder, so that it is finished there, too.
pub fn take_over(from: &Path, folder: &Path) -> Result<()> {
    forget(folder)?;
    let checkpoint = Checkpoint::read(from)?.context("the best start has no checkpoint")?;
    let copy = |name: &str| -> Result<()> {
        let bytes = mesh::io::read_bytes(&from.join(name))?;
        Ok(mesh::io::write_atomic(&folder.join(name), |out| out.write_all(&bytes))?)
    };
    checkpoint.files.keys().map(String::as_str).chain(OF_START).try_for_each(copy)?;
    for entry in std::fs::read_dir(from).with_context(|| from.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.starts_with("castable.") {
            copy(&name)?;
        }
    }
    Ok(())
}
