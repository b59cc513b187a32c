//! Text files, configuration files and fingerprints of files.

use std::path::Path;

use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::{IoError, read_bytes};

/// Reads a text file.
///
/// # Errors
/// If the file cannot be read or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, IoError> {
    String::from_utf8(read_bytes(path)?).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        IoError::content(path, format!("byte {at} is not UTF-8; a text file is needed"))
    })
}

/// Reads a TOML configuration.
///
/// # Errors
/// If the file cannot be read or does not fit `T`; the message shows the line
/// and, for types that deny unknown fields, lists the valid keys.
pub fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T, IoError> {
    let text = read_text(path)?;
    toml::from_str(&text).map_err(|e| IoError::content(path, e.to_string().trim_end()))
}

/// SHA-256 of a file's content, hexadecimal.
///
/// # Errors
/// If the file cannot be read.
pub fn sha256_file(path: &Path) -> Result<String, IoError> {
    let digest = Sha256::digest(read_bytes(path)?);
    Ok(digest.iter().map(|byte| format!("{byte:02x}")).collect())
}
