//! From which file a body came, and which part of it is cast.

use std::path::PathBuf;

use program::{InputFile, Names};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::orientation::Portion;
use crate::config::Casts;

/// Where the body came from.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// The mesh, relative to the folder of this file.
    pub path: PathBuf,
    /// SHA-256 of its content.
    pub sha256: String,
    /// Tags of the walls of its chambers.
    pub chamber: Names,
    /// Which part of it is cast.
    pub part: CastPart,
    /// Which surface of it is cast.
    #[serde(default)]
    pub surface: Casts,
    /// The surface that it was meshed from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<InputFile>,
    /// The mesh as modelled, if it was designed since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modelled: Option<InputFile>,
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
