//! Temporary folders.

use anyhow::{Context as _, Result};
use tempfile::TempDir;

/// A new folder for temporary files, which only this user may enter, with a name that nobody can guess.
pub fn temporary_folder(prefix: &str) -> Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    if let Some(private) = system::permissions(0o700) {
        builder.permissions(private);
    }
    let above = std::env::temp_dir();
    let made = builder.prefix(prefix).tempdir_in(&above);
    made.with_context(|| format!("{}: cannot create a temporary folder", above.display()))
}
