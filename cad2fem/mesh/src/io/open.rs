//! The one place where files are opened.
//!
//! Folders, pipes and devices are never opened in place of files, so that nothing waits for a writer that never
//! comes; what the program was started with is (`/dev/stdin`, `<(...)`).

use std::fs::{DirBuilder, File, OpenOptions};
use std::path::Path;

use super::IoError;

/// Makes a folder, and those above that are missing.
pub fn make_folder(folder: &Path) -> Result<(), IoError> {
    let made = DirBuilder::new().recursive(true).create(folder);
    made.map_err(|cause| IoError::system(folder, "create the folder", cause))
}

/// Opens a file to be read.
pub fn open_input(path: &Path) -> Result<File, IoError> {
    if !is_device(path) {
        require_file(path)?;
    }
    let opened = OpenOptions::new().read(true).open(path);
    opened.map_err(|cause| IoError::system(path, "read", cause))
}

/// Opens a file to be read and written at its end; makes it if it is missing.
pub fn open_to_append(path: &Path) -> Result<File, IoError> {
    require_file(path)?;
    let opened = OpenOptions::new().read(true).append(true).create(true).open(path);
    opened.map_err(|cause| IoError::system(path, "open", cause))
}

/// Makes a file that was not there.
pub fn create_new(path: &Path) -> Result<File, IoError> {
    let made = OpenOptions::new().write(true).create_new(true).open(path);
    made.map_err(|cause| IoError::system(path, "create", cause))
}

/// Opens a device or a pipe below `/dev` to be written. `None` if `path` is none.
pub(super) fn open_device(path: &Path) -> Result<Option<File>, IoError> {
    let named = path.starts_with("/dev") || is_device(path);
    if !named || !std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Ok(None);
    }
    let opened = OpenOptions::new().write(true).open(path);
    opened.map(Some).map_err(|cause| IoError::system(path, "open", cause))
}

/// Whether a path names what the program was started with.
fn is_device(path: &Path) -> bool {
    let folders = ["/dev/fd", "/dev/stdin", "/dev/stdout", "/dev/stderr", "/proc/self/fd"];
    folders.iter().any(|folder| path.starts_with(folder))
}

/// What is there is a file, or a link to one.
fn require_file(path: &Path) -> Result<(), IoError> {
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            Err(IoError::content(path, "it is a folder; a file is needed"))
        }
        Ok(found) if !found.is_file() => {
            Err(IoError::content(path, "it is a pipe or a device; a file is needed"))
        }
        _ => Ok(()),
    }
}
