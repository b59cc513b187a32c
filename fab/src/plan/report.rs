//! `plan.json`: how a body is to be molded, why, and which molds that takes.

use std::path::{Component, Path};

use anyhow::Result;
use geometry::{MM, Triple};
use mesh::io::IoError;
use program::write_json;
use serde::{Deserialize, Serialize};

use super::Casting;
use crate::body::source::Input;
use crate::body::walls::Wall;
use crate::body::weight::Weight;
use crate::config::method::Method;

/// Name of the plan in the top folder.
pub const FILE: &str = "plan.json";

/// Whether a folder lies in the plan's own.
fn is_inside(folder: &str) -> bool {
    let mut parts = Path::new(folder).components();
    parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

/// The content of plan.json. Lengths are millimetres, directions those of the design.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PlanReport {
    /// Program and version.
    pub program: String,
    /// Unit of every length in this file.
    pub units: String,
    /// The body.
    pub input: Input,
    /// How it is molded.
    pub method: Method,
    /// Whether that was measured or asked for in mold.toml.
    pub chosen_by: ChosenBy,
    /// Why, with numbers.
    pub reason: String,
    /// Every number that led to the choice.
    pub measures: Vec<Measure>,
    /// Whether each of the methods can be used, and why.
    pub methods: Vec<Verdict>,
    /// Directions of the pull that were measured, the best first.
    pub directions: Vec<Direction>,
    /// The molds to print and cast, in the order of casting.
    pub molds: Vec<Entry>,
    /// From castings to the body: what to do, in order.
    pub steps: Vec<String>,
    /// What the finished body weighs, if the density of its silicone is known.
    #[serde(default)]
    pub weight: Option<Weight>,
    /// The thinnest wall of the body.
    #[serde(default)]
    pub wall: Option<ThinnestWall>,
}

/// The thinnest wall of a body.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ThinnestWall {
    /// How thick it is [mm].
    pub thickness: f64,
    /// Where it begins, in the design [mm].
    pub at: Triple,
    /// On what it was measured: "model" or "mesh".
    pub on: String,
}

/// Who chose.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChosenBy {
    /// What was measured.
    Measures,
    /// `method` in mold.toml.
    Configuration,
}

/// A number that was measured.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// What it is of.
    pub name: String,
    /// The number.
    pub value: f64,
    /// The unit; empty for a ratio.
    pub unit: String,
    /// What it is compared with, if with anything.
    pub limit: Option<f64>,
    /// What it means and how it was measured.
    pub meaning: String,
}

/// Whether a method can be used.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// The method.
    pub method: Method,
    /// Whether it can be used.
    pub possible: bool,
    /// Why, with numbers.
    pub reason: String,
}

/// The undercuts of two shells that separate along a direction.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Direction {
    /// The direction in the design [1].
    pub pull: Triple,
    /// Whether a mold can be made so: along or across `up`.
    pub usable: bool,
    /// Part of the area in undercuts along it, at best [%].
    pub undercut: f64,
    /// How far the mold reaches under the body there, at most [mm].
    pub depth: f64,
}

/// One of the molds.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// The folder, relative to the plan's; "." for the plan's own.
    pub folder: String,
    /// The name.
    pub name: String,
}

impl PlanReport {
    /// Reads the plan in `folder`.
    pub fn read(folder: &Path) -> Result<Self, IoError> {
        let path = folder.join(FILE);
        let text = mesh::io::read_own_text(&path)?;
        let read: Self =
            serde_json::from_str(&text).map_err(|e| IoError::content(&path, e.to_string()))?;
        match read.molds.iter().find(|entry| !is_inside(&entry.folder)) {
            None => Ok(read),
            Some(Entry { folder, .. }) => {
                let message = format!("a mold in {folder:?}; its folder must lie in the plan's");
                Err(IoError::content(&path, message))
            }
        }
    }

    /// Writes the plan into `folder`.
    pub fn write(&self, folder: &Path) -> Result<()> {
        write_json(&folder.join(FILE), self)
    }
}

/// The molds of castings.
pub(super) fn entries(castings: &[Casting]) -> Vec<Entry> {
    let entry = |casting: &Casting| Entry {
        folder: if castings.len() == 1 { ".".into() } else { format!("{}-mold", casting.name) },
        name: casting.name.clone(),
    };
    castings.iter().map(entry).collect()
}

impl From<Wall> for ThinnestWall {
    fn from(Wall { thickness, at, on }: Wall) -> Self {
        Self { thickness: MM * thickness, at: (MM * at).into(), on: on.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn molds_lie_in_the_folder_of_the_plan() {
        assert!([".", "lid-mold", "./a/b"].into_iter().all(is_inside));
        assert!(!["..", "../lid", "/tmp", "a/../../b"].into_iter().any(is_inside));
    }
}
