//! Entries that the reports of several verbs share.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use mesh::SurfaceMesh;
use mesh::check::Finding;
use mesh::measure::unlikely_size;
use program::sha256_file;
use serde::Serialize;

/// An input file and its fingerprint.
#[derive(Clone, Debug, Serialize)]
pub struct Input {
    /// Path as it was given.
    pub path: String,
    /// SHA-256 of the content.
    pub sha256: String,
    /// What was set from outside, as it was given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
}

impl Input {
    /// Fingerprints a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn of(path: &Path) -> Result<Self> {
        Ok(Self { path: path.display().to_string(), sha256: sha256_file(path)?, set: Vec::new() })
    }
}

/// Warns of a surface [m] whose size hints at another unit.
pub fn remark_on_size(file: &Path, surface: &SurfaceMesh) {
    if let Some(remark) = unlikely_size(&surface.vertices) {
        log::warn!("{}: {remark}", file.display());
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
