//! The checkout that this program was built in.

use std::path::{Path, PathBuf};

/// What `make install` leaves beside the folder of the programs: a link to the checkout.
const LINK: &str = "lib/puffer/checkout";

/// The nearest folder above the program that holds its sources, or for an installed program the one
/// that it was installed from. The working directory does not count: what lies there by chance is
/// neither run nor used.
#[must_use]
pub fn checkout() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let holds_sources = |folder: &&Path| folder.join("cad2fem/Cargo.toml").is_file();
    if let Some(folder) = program.ancestors().find(holds_sources) {
        return Some(folder.to_path_buf());
    }
    let linked = program.parent()?.parent()?.join(LINK).canonicalize().ok()?;
    holds_sources(&linked.as_path()).then_some(linked)
}
