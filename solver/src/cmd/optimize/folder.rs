//! The folder of an optimisation: what a run before has left there.

use std::path::Path;

use anyhow::{Context, Result};
use reports::{Ended, Optimization};

use design::optimize::Checkpoint;
use run::report::results;

/// The report of a design in the folder, if there is one; those of other commands are none.
pub(super) fn report(folder: &Path) -> Result<Option<Optimization>> {
    let path = folder.join("report.json");
    if !path.exists() {
        return Ok(None);
    }
    let report = serde_json::from_str(&mesh::io::read_own_text(&path)?);
    let report: serde_json::Value = report.with_context(|| path.display().to_string())?;
    Ok(serde_json::from_value(report).ok())
}

/// Whether the folder holds a finished design.
pub(super) fn finished(folder: &Path) -> Result<bool> {
    Ok(report(folder)?.is_some_and(|report| report.usable))
}

/// Whether the folder holds an optimisation of other inputs that is finished or
/// has no result. Any other is removed with --restart only.
pub(super) fn outdated(folder: &Path, inputs: &str) -> Result<bool> {
    let finished = finished(folder)?;
    Ok(Checkpoint::read(folder)?
        .is_some_and(|c| c.inputs != inputs && (finished || c.history == 0)))
}

/// Whether the report in the folder is of a design whose next level could not begin: to try it again would lose it.
pub(super) fn is_kept_before_a_level(folder: &Path) -> Result<bool> {
    let report = report(folder)?.filter(|report| report.usable);
    let levels = report.and_then(|report| report.designed).map(|designed| designed.levels);
    Ok(levels.iter().flatten().last().is_some_and(|end| end.ending == Ended::NoEquilibrium))
}

/// Removes the report of a failure once the run continues.
pub(super) fn forget_failure(folder: &Path) -> Result<()> {
    let failed = report(folder)?.is_some_and(|report| !report.usable);
    if failed {
        remove(folder, |name| ["report.json", results::FAILED].contains(&name))
    } else {
        Ok(())
    }
}

/// Removes what a run without a first evaluation cannot be continued from.
pub(super) fn forget_start(folder: &Path) -> Result<()> {
    if Checkpoint::read(folder)?.is_none_or(|c| c.history > 0) {
        return Ok(());
    }
    remove(folder, |name| {
        ["checkpoint.json", "history.jsonl"].contains(&name)
            || name.starts_with("level-") && name.ends_with(".msh")
    })
}

/// Removes all that an optimisation has written but the meshes that its levels begin with.
pub(super) fn forget(folder: &Path) -> Result<()> {
    let names = [
        "checkpoint.json",
        "history.jsonl",
        "report.json",
        "result.vtu",
        "pressures.toml",
        "parameters.toml",
        results::FAILED,
    ];
    let meshes = ["design.", "latest.", "castable.", "remeshed-"];
    remove(folder, |name| {
        names.contains(&name)
            || name.ends_with(".msh") && meshes.iter().any(|first| name.starts_with(first))
            || name.starts_with("run-") && name.ends_with(".npy")
    })
}

/// Removes the files whose names are these.
pub(super) fn remove(folder: &Path, is_one: impl Fn(&str) -> bool) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| is_one(&name.to_string_lossy())) {
            mesh::io::remove_output(&path)?;
        }
    }
    Ok(())
}
