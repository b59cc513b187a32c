//! Simulations beside measurements: the simulated value of each measured point, and its error.

mod row;
mod states;
pub mod table;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use reports::{Comparison, MeasuredPoint};
use schemars::JsonSchema;
use serde::Deserialize;

use self::states::{Met, interpolate, passages, turns};
use self::table::Table;
use run::report::columns::{number, rows};

/// What is compared: a file in TOML.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Measured curves with their simulations.
    #[serde(default)]
    pub row: Vec<Row>,
}

/// A measured curve with its simulations.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The name in the table.
    pub name: String,
    /// Measured table (CSV), relative to the file.
    pub measured: PathBuf,
    /// Entries that its lines must have, by the titles of columns.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub lines: BTreeMap<String, toml::Value>,
    /// Title of the abscissa.
    pub x: String,
    /// Smallest and largest abscissa that count.
    pub range: Option<[f64; 2]>,
    /// Titles of the ordinate; of several, such as repeated trials, the mean.
    pub y: Vec<String>,
    /// Title of the spread of the ordinate; without it, half the range of several ordinates.
    pub spread: Option<String>,
    /// What a simulated state must have in common with a measured line. With `passage` there may be none: then all
    /// states meet it.
    #[serde(default)]
    pub condition: Vec<Condition>,
    /// Which of several states that meet the one condition counts, where the run goes back and forth; without it
    /// there may be no more than one.
    pub passage: Option<Passage>,
    /// Column of the simulated ordinate, in the unit of the measured one.
    pub simulated: String,
    /// Whether the simulated ordinate counts from its value after the first step.
    #[serde(default)]
    pub from_first_step: bool,
    /// Smallest and largest simulated over measured ordinate − 1 that is tolerated at any point.
    pub tolerance: [f64; 2],
    /// Why this much is tolerated: shown beside the errors.
    pub reason: Option<String>,
    /// What is assumed of the body: shown beside the errors.
    pub assumed: Option<String>,
    /// Which measurements of the same source were not looked at: shown beside the errors.
    pub held_back: Option<String>,
    /// Name of the picture that it is drawn in.
    pub plot: String,
    /// Simulations. Runs of one name are one, each for other lines of the table.
    pub run: Vec<Run>,
    /// Names of two simulations between which the measured ordinates are expected. They are compared as one: what of
    /// the band is nearest to the measured ordinate counts as simulated.
    pub band: Option<[String; 2]>,
}

/// A quantity that a simulated state has in common with a measured line.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// Title of the measured column.
    pub measured: Option<String>,
    /// The value that all lines have, in place of a column.
    pub value: Option<f64>,
    /// Column of the simulation, in the unit of the measured one.
    pub simulated: String,
    /// Whether the simulated quantity counts from its value after the first step.
    #[serde(default)]
    pub from_first_step: bool,
}

/// One of several states that meet a condition, in the order of the run.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Passage {
    /// The first.
    First,
    /// The last.
    Last,
    /// The one that follows along the run on that of the line before; for the first line, the first.
    Next,
    /// Where the ordinate first has a maximum along the run, as the pressure of a wall that buckles. Without condition.
    Peak,
    /// Where the ordinate has its first minimum after that maximum. Without condition.
    Valley,
}

/// A simulation of a row.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// The name in tables and pictures.
    pub name: String,
    /// The steps: report.json or steps.jsonl, relative to the file.
    pub steps: PathBuf,
    /// Entries that the lines must have that it simulates, by the titles of columns, beside those of the row.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub lines: BTreeMap<String, toml::Value>,
    /// Whether parameters of it come from these measurements.
    #[serde(default)]
    pub fitted: bool,
}

/// A measured point, with the values of the row's conditions.
#[derive(Clone, Debug)]
struct Point {
    measured: MeasuredPoint,
    conditions: Vec<f64>,
}

impl Config {
    /// Compares every run of every row; paths are relative to `folder`.
    pub fn compare(&self, folder: &Path) -> Result<Vec<Comparison>> {
        ensure!(!self.row.is_empty(), "no [[row]]: there is nothing to compare");
        let compared =
            |row: &Row| row.compared(folder).with_context(|| format!("[[row]] \"{}\"", row.name));
        Ok(self.row.iter().map(compared).collect::<Result<Vec<_>>>()?.concat())
    }
}
