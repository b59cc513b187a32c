//! What is installed with this program: rules for make, and the Python whose package it lies in.

use std::path::{Path, PathBuf};

use crate::checkout::{checkout, unchanged};

/// What make or the shell take for their own in a name, as in `pipelines/chain.mk`.
pub const SPECIAL: &str = "$;:*?[]{}()<>&|!'\"`\\~%=^# \t\n";

/// Files for all programs, beside the folder of the programs: in the Python package, in the archive of
/// `make dist` and where `make install` put them.
const SHARE: &str = "share/puffer";

/// The rules that the Makefile of a body includes, and what they include.
const RULES: [&str; 2] = ["folder.mk", "chain.mk"];

/// The folder of files that came with this program, if nobody else can change its rules for make.
pub fn share() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?.parent()?.join(SHARE);
    holds_rules(&folder).then_some(folder)
}

/// The rules that the Makefile of a body includes: those that came with this program, else those of its checkout.
pub fn rules() -> Option<PathBuf> {
    let of_checkout = || checkout().map(|top| top.join("pipelines")).filter(|f| holds_rules(f));
    share().or_else(of_checkout).map(|folder| folder.join(RULES[0]))
}

fn holds_rules(folder: &Path) -> bool {
    folder.join(RULES[0]).is_file() && unchanged(folder, &["", RULES[0], RULES[1]])
}

/// The Python of the environment that this program was installed into by pip, if nobody else can change it: of
/// `PREFIX/lib/python3.11/site-packages/softpuffer/bin/cad2fem` this is `PREFIX/bin/python3.11`.
pub fn python() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let packages = program.ancestors().nth(3)?;
    let library = packages.parent().filter(|_| packages.ends_with("site-packages"))?;
    let name = library.file_name()?.to_str().filter(|name| name.starts_with("python3"))?;
    let prefix = library.parent()?.parent()?;
    let python = prefix.join("bin").join(name);
    (python.is_file() && unchanged(&prefix.join("bin"), &["", name])).then_some(python)
}
