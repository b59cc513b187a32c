//! What must not outlive the program: files that are being written, folders of jobs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What the names of files begin with that are being written.
pub(super) const PREFIX: &str = ".incomplete-";

static PATHS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn paths() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PATHS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder that an interrupted program removes, until this is dropped.
#[derive(Debug)]
pub struct Unfinished(PathBuf);

impl Unfinished {
    /// Makes a file or folder, and from then on it is known.
    pub fn new<T, E>(
        make: impl FnOnce() -> Result<T, E>,
        path: impl FnOnce(&T) -> PathBuf,
    ) -> Result<(T, Self), E> {
        let mut paths = paths(); // an interruption waits until it is there and known
        let made = make()?;
        let path = path(&made);
        paths.insert(path.clone());
        Ok((made, Self(path)))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        paths().remove(&self.0);
    }
}

/// Removes all that is unfinished. While the result is held nothing new begins.
pub fn remove_unfinished() -> impl Sized {
    let paths = paths();
    for path in paths.iter() {
        // what cannot be removed stays: the program ends
        let _ =
            if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
    }
    paths
}

/// Removes the unfinished files that a killed program left in a folder whose only writer this is.
/// Litter is no reason to fail: what cannot be read or removed stays.
pub fn remove_litter(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let ours = paths();
    for entry in entries.flatten() {
        let named = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if named && !ours.contains(&entry.path()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}
