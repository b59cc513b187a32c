//! Files from which a program continues: JSON with the program that wrote it and the SHA-256 of
//! its content. A file that was altered since, or that another version wrote, is never used.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::sha256;

/// What to do with a file that cannot be used.
const REMEDY: &str = "start over with --restart, or take another output folder";

#[derive(Serialize)]
struct Written<'a> {
    program: &'a str,
    sha256: String,
    content: &'a RawValue,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Read<'a> {
    program: String,
    sha256: String,
    #[serde(borrow)]
    content: &'a RawValue,
}

/// Writes `content` as a whole, or leaves the file as it was. `program` is its name and version.
pub fn write_checkpoint<T: Serialize>(path: &Path, program: &str, content: &T) -> Result<()> {
    let content = serde_json::value::to_raw_value(content)?;
    let sha256 = sha256(content.get().as_bytes());
    let written = Written { program, sha256, content: &content };
    mesh::io::write_atomic(path, |out| {
        serde_json::to_writer(out, &written).map_err(std::io::Error::from)
    })?;
    Ok(())
}

/// What [`write_checkpoint`] wrote.
pub fn read_checkpoint<T: DeserializeOwned>(path: &Path, program: &str) -> Result<T> {
    let text = mesh::io::read_own_text(path)?;
    let broken = || format!("{}: broken checkpoint; {REMEDY}", path.display());
    let read: Read = serde_json::from_str(&text).with_context(broken)?;
    ensure!(
        read.program == program,
        "{}: a checkpoint of {}, this is {program}; {REMEDY}",
        path.display(),
        read.program
    );
    let found = sha256(read.content.get().as_bytes());
    ensure!(
        read.sha256 == found,
        "{}: its content has the SHA-256 {found:.8}…, expected {:.8}…: it was altered",
        broken(),
        read.sha256
    );
    serde_json::from_str(read.content.get()).with_context(broken)
}

/// Makes sure that a file is as it was when its SHA-256 was put into a checkpoint.
pub fn check_unaltered(path: &Path, sha256: &str) -> Result<()> {
    let found = crate::sha256_file(path).context(REMEDY)?;
    ensure!(
        found == sha256,
        "{}: it has the SHA-256 {found:.8}…, the checkpoint expects {sha256:.8}…: it was altered; \
         {REMEDY}",
        path.display()
    );
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn one_altered_digit_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.json");
        let content = vec![0.1, 2.0_f64.sqrt(), 1e-300];
        write_checkpoint(&path, "solver 1", &content).unwrap();
        assert_eq!(read_checkpoint::<Vec<f64>>(&path, "solver 1").unwrap(), content);
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to, expected) in [
            ("1.4142", "1.4143", "altered"),
            ("0.1,", "0.1 ,", "altered"),
            ("\"content\":[", "\"content\":{", "broken"),
            ("solver 1", "solver 2", "a checkpoint of solver 2"),
            ("sha256", "sha257", "broken"),
        ] {
            assert!(text.contains(from), "{text}");
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let error = read_checkpoint::<Vec<f64>>(&path, "solver 1").unwrap_err();
            let message = format!("{error:#}");
            assert!(message.contains(expected) && message.contains("--restart"), "{message}");
        }
    }
}
