//! Tables for spreadsheets and pandas.

use std::path::Path;

use anyhow::{Context, Result};

/// Writes rows with commas.
pub fn write(path: &Path, rows: impl IntoIterator<Item = Vec<String>>) -> Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    for row in rows {
        table.write_record(row)?;
    }
    let text = table.into_inner().context("a table in memory")?;
    Ok(mesh::io::write_atomic(path, |out| out.write_all(&text))?)
}
