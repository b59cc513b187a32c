//! SHA-256, by which results name their inputs.

use std::path::Path;

use mesh::io::{IoError, open_input};
use sha2::{Digest, Sha256};

/// SHA-256 of some bytes, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a file's content, hexadecimal; the file is never in memory as a whole.
pub fn sha256_file(path: &Path) -> Result<String, IoError> {
    let fail = |cause| IoError::System { path: path.to_owned(), action: "read", cause };
    let mut file = open_input(path)?;
    let mut digest = Sha256::new();
    std::io::copy(&mut file, &mut digest).map_err(fail)?;
    Ok(hexadecimal(&digest.finalize()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_standard() {
        // FIPS 180-2, example B.1.
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), known);
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(file.path(), "abc").expect("it is writable");
        assert_eq!(sha256_file(file.path()).expect("readable"), known);
    }
}
