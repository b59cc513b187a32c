//! Entries that the reports of several verbs share.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use mesh::check::Finding;
use program::sha256_file;
use serde::Serialize;

/// An input file and its fingerprint.
#[derive(Clone, Debug, Serialize)]
pub struct Input {
    /// Path as it was given.
    pub path: String,
    /// SHA-256 of the content.
    pub sha256: String,
}

impl Input {
    /// Fingerprints a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn of(path: &Path) -> Result<Self> {
        Ok(Self { path: path.display().to_string(), sha256: sha256_file(path)? })
    }
}

/// Findings of validity checks, one indented line each.
#[must_use]
pub fn findings(found: &[Finding]) -> String {
    found.iter().fold(String::new(), |mut text, f| {
        // Writing to a String cannot fail.
        let _ = write!(text, "\n  {}: {}", f.rule, f.message);
        text
    })
}
