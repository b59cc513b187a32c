//! Entries that the reports of several verbs share.

use std::path::Path;

use anyhow::{Result, bail};
use mesh::SurfaceMesh;
use mesh::io::read_surface;
use mesh::measure::{diagonal, unlikely_size};
use program::sha256_file;
use serde::Serialize;

use program::units::{Unit, sizes};

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
    pub fn of(path: &Path) -> Result<Self> {
        Ok(Self { path: path.display().to_string(), sha256: sha256_file(path)?, set: Vec::new() })
    }
}

/// Reads a surface whose lengths are metres or in the unit that the user says.
pub fn read_in(path: &Path, unit: Option<Unit>) -> Result<SurfaceMesh> {
    let mut surface = read_surface(path)?;
    let unlikely = unlikely_size(&surface.vertices).is_some();
    if let (None, true) = (unit, unlikely) {
        bail!("{}: {}", path.display(), sizes(diagonal(&surface.vertices)));
    }
    let metres = unit.unwrap_or(Unit::M).metres();
    surface.vertices.iter_mut().for_each(|v| *v *= metres);
    Ok(surface)
}

/// Warns of a surface [m] whose size hints at another unit.
pub fn remark_on_size(file: &Path, surface: &SurfaceMesh) {
    if let Some(remark) = unlikely_size(&surface.vertices) {
        log::warn!("{}: {remark}", file.display());
    }
}
