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

#[cfg(test)]
mod tests {
    use super::*;

    fn file(content: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::Builder::new().suffix(".toml").tempfile().expect("a temporary file");
        std::fs::write(file.path(), content).expect("it is writable");
        file
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only the names matter")]
    struct Mold {
        wall: f64,
        clearance: f64,
    }

    #[test]
    fn an_unknown_key_names_file_line_and_valid_keys() {
        let file = file(b"wall = 2.0\nclearence = 0.2\n");
        let message = read_toml::<Mold>(file.path()).expect_err("misspelt").to_string();
        for needed in [".toml", "line 2", "clearence", "`wall`", "`clearance`"] {
            assert!(message.contains(needed), "{needed} is not in: {message}");
        }
    }

    #[test]
    fn text_must_be_utf8_and_exist() {
        let message = read_text(file(b"ab\xffc").path()).expect_err("not UTF-8").to_string();
        assert!(message.contains("byte 2"), "{message}");
        let message = read_text(Path::new("/no/such")).expect_err("missing").to_string();
        assert!(message.contains("/no/such"), "{message}");
    }

    #[test]
    fn the_digest_is_that_of_the_standard() {
        // FIPS 180-2, example B.1.
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_file(file(b"abc").path()).expect("readable"), known);
    }
}
