//! What was installed with this program: rules for make, and the Python whose package it lies in; or the checkout that
//! it was built in.

use std::path::{Path, PathBuf};

/// What make or the shell take for their own in a name, as in `pipelines/chain.mk`.
pub const SPECIAL: &str = "$;:*?[]{}()<>&|!'\"`\\~%=^# \t\n";

/// What `make install` leaves beside the folder of the programs: a link to the checkout.
const LINK: &str = "lib/puffer/checkout";

/// Files for all programs, beside the folder of the programs: in the Python package, in the archive of
/// `make dist` and where `make install` put them.
const SHARE: &str = "share/puffer";

/// The rules that the Makefile of a body includes.
const RULES: &str = "folder.mk";

/// The nearest folder above the program that holds its sources, or for an installed program the one
/// that it was installed from. The working directory does not count: what lies there by chance is
/// neither run nor used.
pub fn checkout() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let holds_sources = |folder: &&Path| folder.join("cad2fem/Cargo.toml").is_file();
    if let Some(folder) = program.ancestors().find(holds_sources) {
        return Some(folder.to_path_buf());
    }
    let linked = system::canonical(&program.parent()?.parent()?.join(LINK)).ok()?;
    holds_sources(&linked.as_path()).then_some(linked)
}

/// The folder of files that came with this program.
pub fn share() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?.parent()?.join(SHARE);
    folder.join(RULES).is_file().then_some(folder)
}

/// The rules that the Makefile of a body includes: those that came with this program, else those of its checkout.
pub fn rules() -> Option<PathBuf> {
    let of_checkout = || checkout().map(|top| top.join("pipelines"));
    let file = share().or_else(of_checkout)?.join(RULES);
    file.is_file().then_some(file)
}

/// The Python of the environment that this program was installed into by pip: of
/// `PREFIX/lib/python3.11/site-packages/softpuffer/bin/cad2fem` this is `PREFIX/bin/python3.11`. On Windows it is
/// `python.exe` in `PREFIX` or `PREFIX/Scripts`, of `PREFIX/Lib/site-packages/softpuffer/bin/cad2fem.exe`.
pub fn python() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let packages = program.ancestors().nth(3)?;
    let library = packages.parent().filter(|_| packages.ends_with("site-packages"))?;
    if cfg!(windows) {
        let places = ["Scripts/python.exe", "python.exe"].map(|name| library.with_file_name(name));
        return places.into_iter().find(|place| place.is_file());
    }
    let name = library.file_name()?.to_str().filter(|name| name.starts_with("python3"))?;
    let python = library.parent()?.parent()?.join("bin").join(name);
    python.is_file().then_some(python)
}
