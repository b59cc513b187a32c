//! The checkout that this program was built in.

use std::path::{Path, PathBuf};

use program::is_as_safe_as_program;

/// What `make install` leaves beside the folder of the programs: a link to the checkout.
const LINK: &str = "lib/puffer/checkout";

/// The nearest folder above the program that holds its sources, or for an installed program the one
/// that it was installed from. The working directory does not count: what lies there by chance is
/// neither run nor used, and neither is a folder that others than the user, root and the owner of the program
/// can change.
pub fn checkout() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let holds_sources = |folder: &&Path| folder.join("cad2fem/Cargo.toml").is_file();
    if let Some(folder) = program.ancestors().find(holds_sources) {
        return unchanged(folder, &[""]).then(|| folder.to_path_buf());
    }
    let prefix = program.parent()?.parent()?;
    let linked = system::canonical(&prefix.join(LINK)).ok()?;
    let safe = holds_sources(&linked.as_path()) && unchanged(prefix, &["lib", "lib/puffer", LINK]);
    safe.then_some(linked)
}

/// Whether nobody else can have put there what lies at these places below `folder`; says where one can.
pub(crate) fn unchanged(folder: &Path, below: &[&str]) -> bool {
    let others = below.iter().map(|name| folder.join(name)).find(|p| !is_as_safe_as_program(p));
    if let Some(place) = &others {
        log::warn!(
            "{}: not used, as others than you, root and the owner of this program can change it",
            place.display()
        );
    }
    others.is_none()
}
