//! The checkout that this program was built in.

use std::path::{Path, PathBuf};

/// The nearest folder above the program that holds its sources. The working directory does not
/// count: what lies there by chance is neither run nor used.
#[must_use]
pub fn checkout() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let mut folders = program.ancestors();
    folders.find(|folder| folder.join("cad2fem/Cargo.toml").is_file()).map(Path::to_path_buf)
}
