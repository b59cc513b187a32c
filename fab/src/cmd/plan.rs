//! `fab plan`: how a body is to be molded, and why.

use anyhow::Result;
use program::FolderLock;

use super::{Planned, Task, proof};
use crate::plan::drawing;

/// Runs the verb.
pub fn run(task: &Task) -> Result<()> {
    let Planned { plan, report, .. } = proof::holding(task, task.plan()?)?;
    let _lock = FolderLock::new(&task.output)?;
    report.write(&task.output)?;
    if !task.no_pictures {
        drawing::draw(&task.output.join(drawing::FILE), &plan)?;
    }
    Ok(())
}
