//! `fab plan`: how a body is to be molded, and why.

use anyhow::Result;

use super::{Planned, Task};
use crate::plan::report::{Entry, Material};
use crate::plan::{Plan, drawing};

/// Runs the verb.
///
/// # Errors
/// If the mesh or the configuration cannot be used, the body cannot be molded, or
/// plan.json or the picture cannot be written.
pub fn run(task: &Task) -> Result<()> {
    let Planned { plan, told, .. } = task.plan()?;
    told.write(&task.output)?;
    drawing::draw(&task.output.join(drawing::FILE), &plan)?;
    Ok(())
}

/// The molds of a plan, cores of wax first.
#[must_use]
pub fn entries(plan: &Plan, cores: usize) -> Vec<Entry> {
    let mut entries = Vec::new();
    if plan.method == crate::method::Method::Wax {
        for i in 0..cores {
            let name = if cores == 1 { "core".into() } else { format!("core{}", i + 1) };
            entries.push(Entry { folder: format!("{name}-mold"), name, casts: Material::Wax });
        }
    }
    let single = entries.is_empty() && plan.castings.len() == 1;
    entries.extend(plan.castings.iter().map(|casting| Entry {
        folder: if single { ".".into() } else { format!("{}-mold", casting.name) },
        name: casting.name.clone(),
        casts: Material::Silicone,
    }));
    entries
}
