//! Reports: JSON that people read, too.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;

/// Writes JSON with indentation, as a whole or not at all.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)?;
    mesh::io::write_atomic(path, |out| writeln!(out, "{text}"))?;
    Ok(())
}
