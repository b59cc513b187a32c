//! `fab plan`: how a body is to be molded, and why.

use anyhow::Result;
use program::FolderLock;

use super::{Planned, Task, proof};
use crate::plan::drawing;

/// Runs the verb.
///
/// # Errors
/// If the mesh or the configuration cannot be used, the body cannot be molded, cores would lean in the
/// mold that was asked for, or plan.json or the picture cannot be written.
pub fn run(task: &Task) -> Result<()> {
    let Planned { plan, report, .. } = proof::holding(task, task.plan()?)?;
    let _lock = FolderLock::new(&task.output)?;
    report.write(&task.output)?;
    if !task.no_pictures {
        drawing::draw(&task.output.join(drawing::FILE), &plan)?;
    }
    Ok(())
}
