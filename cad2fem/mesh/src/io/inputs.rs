//! What a program has read is never overwritten or removed by it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::IoError;
use super::open::refuse_link_above;

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
///
/// # Errors
/// If it is an input of this run or cannot be removed.
pub fn remove_output(path: &Path) -> Result<(), IoError> {
    refuse_input(path)?;
    refuse_link_above(path)?;
    missing_is_fine(std::fs::remove_file(path), path)
}

/// Removes a folder of an earlier run with all that it holds, if there is one.
///
/// # Errors
/// If it holds an input of this run or cannot be removed.
pub fn remove_output_folder(path: &Path) -> Result<(), IoError> {
    refuse_input(path)?;
    refuse_link_above(path)?;
    missing_is_fine(std::fs::remove_dir_all(path), path)
}

fn missing_is_fine(removed: std::io::Result<()>, path: &Path) -> Result<(), IoError> {
    match removed {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        removed => removed.map_err(|cause| IoError::system(path, "remove", cause)),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::{read_bytes, read_own_text, read_text, write_atomic};
    use super::*;

    #[test]
    fn an_input_is_not_overwritten_by_any_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let write = |name: &str| write_atomic(&at(name), |out| write!(out, "new"));
        std::fs::write(at("input"), "old").unwrap();
        std::fs::write(at("own"), "old").unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(at("input"), at("link")).unwrap();
        read_text(&at("input")).unwrap();
        read_own_text(&at("own")).unwrap();
        write("own").unwrap();
        write("other").unwrap();
        // what was written by this process may be read and written again
        read_bytes(&at("other")).unwrap();
        write("other").unwrap();
        for name in ["input", "./input", "link"] {
            let message = write(name).unwrap_err().to_string();
            assert!(message.contains("input") || message.contains("link"), "{message}");
            assert!(message.contains("give the output another name"), "{message}");
        }
        assert!(remove_output(&at("input")).is_err());
        let message = remove_output_folder(folder.path()).unwrap_err().to_string();
        assert!(message.contains("/input as its input"), "{message}");
        assert_eq!(std::fs::read_to_string(at("input")).unwrap(), "old");
        remove_output(&at("own")).unwrap();
        remove_output(&at("own")).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn a_file_that_is_too_large_is_not_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        file.as_file().set_len((4 << 30) + 7).unwrap(); // a hole, without blocks on the disk
        let message = read_bytes(file.path()).unwrap_err().to_string();
        assert!(message.contains("4294967303 bytes; up to 4294967296"), "{message}");
    }
}
