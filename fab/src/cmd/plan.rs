//! `fab plan`: how a body is to be molded, and why.

use anyhow::Result;

use super::Task;
use crate::plan::Plan;
use crate::plan::report::{Entry, Material};

/// Runs the verb.
///
/// # Errors
/// If the mesh or the configuration cannot be used, the body cannot be molded, or
/// plan.json cannot be written.
pub fn run(task: &Task) -> Result<()> {
    task.plan()?.told.write(&task.output)?;
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
