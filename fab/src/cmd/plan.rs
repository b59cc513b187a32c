//! `fab plan`: how a body is to be molded, and why.

use anyhow::Result;
use program::FolderLock;

use super::{Planned, Task, proof};
use crate::files::undercut;

/// Runs the verb.
pub fn run(task: &Task) -> Result<()> {
    let Planned { plan, .. } = proof::holding(task, task.plan()?)?;
    let _lock = FolderLock::new(&task.output)?;
    plan.report.write(&task.output)?;
    if !task.no_pictures {
        undercut::draw(&task.output.join(undercut::FILE), &plan)?;
    }
    Ok(())
}
