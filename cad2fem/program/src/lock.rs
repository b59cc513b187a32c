//! One writer for a folder of results.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use mesh::io::{Unfinished, make_folder, open_to_append, remove_litter};

/// The file that is locked.
const NAME: &str = ".lock";

/// The right to write to a folder, until it is dropped. The operating system takes it back when
/// the process ends, however that ends.
#[derive(Debug)]
pub struct FolderLock {
    file: File,
    path: PathBuf,
    _unfinished: Unfinished,
}

impl FolderLock {
    /// Makes the folder if it is missing, and locks it: from now on it is a folder of results.
    pub fn new(folder: &Path) -> Result<Self> {
        make_folder(folder)?;
        let path = folder.join(NAME);
        let (file, unfinished) = Unfinished::new(|| open_to_append(&path), |_| path.clone())?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => bail!(
                "{}: another process writes to this folder; wait until it has ended, or take another folder",
                folder.display()
            ),
            Err(TryLockError::Error(error)) => {
                return Err(error).with_context(|| path.display().to_string());
            }
        }
        remove_litter(folder);
        Ok(Self { file, path, _unfinished: unfinished })
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // a file that stays is locked by nobody
        let _ = std::fs::remove_file(&self.path);
        let _ = self.file.unlock();
    }
}
