//! From which file a body came, and which part of it is cast.

use std::path::{Path, PathBuf};

use mesh::io::IoError;
use program::{relative, sha256_file};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::orientation::Portion;
use crate::config::{Casts, Chambers};

/// Where the body came from.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// The mesh, relative to the folder of this file.
    pub path: PathBuf,
    /// SHA-256 of its content.
    pub sha256: String,
    /// Tags of the walls of its chambers.
    pub chamber: Chambers,
    /// Which part of it is cast.
    pub part: CastPart,
    /// Which surface of it is cast.
    #[serde(default)]
    pub surface: Casts,
    /// The surface that it was meshed from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<NamedFile>,
    /// The mesh as modelled, if it was designed since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modelled: Option<NamedFile>,
}

/// A file that a body was made of.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct NamedFile {
    /// The file, relative to the folder of this one.
    pub path: PathBuf,
    /// SHA-256 of its content.
    pub sha256: String,
}

impl NamedFile {
    /// Names and hashes the file at `path` for a report in `folder`.
    pub fn new(path: &Path, folder: &Path) -> Result<Self, IoError> {
        Ok(Self { path: relative(path, folder), sha256: sha256_file(path)? })
    }

    /// Whether the file at `path` is this one.
    pub fn require(&self, path: &Path) -> Result<(), String> {
        let found = sha256_file(path).map_err(|e| e.to_string())?;
        if found != self.sha256 {
            return Err(format!("{} has changed since the mold was made", path.display()));
        }
        Ok(())
    }
}

/// What of the input is cast.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum CastPart {
    /// All of it.
    Whole,
    /// What is above a height in the mold's coordinates [mm].
    Above(f64),
    /// What is below a height in the mold's coordinates [mm].
    Below(f64),
    /// The input is no mesh in metres but the surface of a core, in the millimetres
    /// of the mold that holds it.
    Core,
}

impl CastPart {
    /// What a mold casts of a design.
    pub fn of(portion: Portion) -> Self {
        // The frame puts the cut at height 0.
        match portion {
            Portion::Whole => Self::Whole,
            Portion::Above(_) => Self::Above(0.0),
            Portion::Below(_) => Self::Below(0.0),
        }
    }
}

impl Input {
    /// Names and hashes the mesh at `path` for a report in `folder`.
    pub fn new(
        path: &Path,
        folder: &Path,
        chamber: &Chambers,
        part: CastPart,
    ) -> Result<Self, IoError> {
        let sha256 = sha256_file(path)?;
        let path = relative(path, folder);
        Ok(Self {
            path,
            sha256,
            chamber: chamber.clone(),
            part,
            surface: Casts::Mesh,
            model: None,
            modelled: None,
        })
    }
}
