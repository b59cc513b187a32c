//! `fab keys`: the keys of mold.toml.

use std::io::Write;

use anyhow::Result;

/// Prints all keys on standard output, as the table in the book.
pub fn run() -> Result<()> {
    std::io::stdout().lock().write_all(crate::config::markdown().as_bytes())?;
    Ok(())
}
