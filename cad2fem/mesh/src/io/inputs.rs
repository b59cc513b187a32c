//! What a program has read is never overwritten or removed by it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::IoError;

/// Files of this process, by their canonical paths.
#[derive(Default)]
struct Files {
    /// Read before anything was written there.
    inputs: BTreeSet<PathBuf>,
    /// Written.
    outputs: BTreeSet<PathBuf>,
}

static FILES: Mutex<Files> =
    Mutex::new(Files { inputs: BTreeSet::new(), outputs: BTreeSet::new() });

fn files() -> MutexGuard<'static, Files> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn note_read(path: &Path) {
    let Ok(path) = system::canonical(path) else { return };
    let mut files = files();
    if !files.outputs.contains(&path) {
        files.inputs.insert(path);
    }
}

pub(super) fn note_written(path: &Path) {
    if let Ok(path) = system::canonical(path) {
        files().outputs.insert(path);
    }
}

/// Makes sure that `path`, and all in it if it is a folder, was not read.
pub(super) fn refuse_input(path: &Path) -> Result<(), IoError> {
    let Ok(canonical) = system::canonical(path) else { return Ok(()) };
    let files = files();
    let Some(input) = files.inputs.range(canonical.clone()..).next() else { return Ok(()) };
    if !input.starts_with(&canonical) {
        return Ok(());
    }
    let which = if *input == canonical { String::new() } else { format!(" {}", input.display()) };
    let message = format!(
        "not replaced: this run has read{} as its input; give the output another name",
        if which.is_empty() { " it" } else { &which }
    );
    Err(IoError::content(path, message))
}

/// Removes a file of an earlier run, if there is one.
pub fn remove_output(path: &Path) -> Result<(), IoError> {
    refuse_input(path)?;
    missing_is_fine(std::fs::remove_file(path), path)
}

/// Removes a folder of an earlier run with all that it holds, if there is one.
pub fn remove_output_folder(path: &Path) -> Result<(), IoError> {
    refuse_input(path)?;
    missing_is_fine(std::fs::remove_dir_all(path), path)
}

fn missing_is_fine(removed: std::io::Result<()>, path: &Path) -> Result<(), IoError> {
    match removed {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        removed => removed.map_err(|cause| IoError::system(path, "remove", cause)),
    }
}
