//! Text files.

use std::path::Path;

use super::{IoError, read_bytes, read_own_bytes};

/// Reads a text file, an input of the program.
pub fn read_text(path: &Path) -> Result<String, IoError> {
    decoded(path, read_bytes(path)?)
}

/// Reads a text file that the program itself wrote, in an earlier run perhaps, and may write
/// again.
pub fn read_own_text(path: &Path) -> Result<String, IoError> {
    decoded(path, read_own_bytes(path)?)
}

fn decoded(path: &Path, bytes: Vec<u8>) -> Result<String, IoError> {
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        IoError::content(path, format!("byte {at} is not UTF-8; a text file is needed"))
    })
}
