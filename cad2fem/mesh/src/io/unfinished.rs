//! What must not outlive the program: files that are being written, folders of jobs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What the names of files begin with that are being written.
pub(super) const PREFIX: &str = ".incomplete-";

/// Nobody writes to one file for so long.
const FORGOTTEN: Duration = Duration::from_secs(3600);

static PATHS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn paths() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PATHS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder that an interrupted program removes, until this is dropped.
#[derive(Debug)]
pub struct Unfinished(PathBuf);

impl Unfinished {
    /// Makes a file or folder, and from then on it is known.
    ///
    /// # Errors
    /// When it cannot be made.
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
pub fn remove_litter(folder: &Path) {
    sweep(folder, Duration::ZERO);
}

/// As [`remove_litter`] in a folder that others write to, too: what nobody has touched for long.
/// Looks into each folder once.
pub(super) fn remove_forgotten(folder: &Path) {
    static SEEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let new = SEEN.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned());
    if new {
        sweep(folder, FORGOTTEN);
    }
}

/// Litter is no reason to fail: what cannot be read or removed stays.
fn sweep(folder: &Path, untouched: Duration) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let ours = paths();
    for entry in entries.flatten() {
        let path = entry.path();
        let named = entry.file_name().to_string_lossy().starts_with(PREFIX);
        let age = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
        if named && !ours.contains(&path) && age().is_some_and(|age| age >= untouched) {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::fs::{File, FileTimes};
    use std::time::SystemTime;

    use super::*;

    #[test]
    fn litter_of_killed_programs_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in [".incomplete-old", ".incomplete-new", "result"] {
            std::fs::write(at(name), "half").unwrap();
        }
        let old = FileTimes::new().set_modified(SystemTime::now() - 2 * FORGOTTEN);
        File::options().write(true).open(at(".incomplete-old")).unwrap().set_times(old).unwrap();
        let mine = at(".incomplete-mine");
        let (_, writing) = Unfinished::new(|| File::create(&mine), |_| mine.clone()).unwrap();
        remove_forgotten(folder.path());
        assert!(!at(".incomplete-old").exists() && at(".incomplete-new").exists());
        remove_litter(folder.path());
        assert!(!at(".incomplete-new").exists() && at("result").exists() && mine.exists());
        drop(writing);
        remove_litter(folder.path());
        assert!(!mine.exists());
    }
}
