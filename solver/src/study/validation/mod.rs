//! Simulations beside measurements: the simulated value of each measured point, and its error.

mod row;
mod states;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use program::table::{Numbers, Table as _, each};
use program::{KeyPath, Misfit, misfit};
use reports::{BandEnd, Comparison, MeasuredPoint};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::states::{passages, turns};
use super::table::{Table, some, unit};
use run::report::columns::{number, rows};

program::table! {
    /// What is compared: a file in TOML.
    #[derive(Clone, Debug)]
    pub struct Config {
        /// Measured curves with their simulations.
        row: Vec<Row> = Vec::new(), each(|row: &Row| KeyPath::list("row").named(&row.name));
    }
}

program::table! {
    /// A measured curve with its simulations.
    #[derive(Clone, Debug)]
    pub struct Row {
        /// The name in the table.
        name: String;
        /// Measured table (CSV), relative to the file.
        measured: PathBuf;
        /// Entries that its lines must have, by the titles of columns.
        #[schemars(with = "BTreeMap<String, serde_json::Value>")]
        r#where: BTreeMap<String, toml::Value> = BTreeMap::new();
        /// Title of the abscissa.
        x: String;
        /// Smallest and largest abscissa that count.
        range: Option<[f64; 2]> = None => "all", ordered;
        /// Titles of the ordinate; of several, such as repeated trials, the mean.
        y: Vec<String>, some;
        /// Title of the spread of the ordinate.
        spread: Option<String> = None => "half the range of several ordinates";
        /// What a simulated state must have in common with a measured line. Without it there is a passage.
        condition: Option<Condition> = None;
        /// Which state of a run counts for all lines, in place of a condition.
        passage: Option<Passage> = None;
        /// Column of the simulated ordinate, in the unit of the measured one.
        simulated: String;
        /// Whether the simulated ordinate counts from its value after the first step.
        from_first_step: bool = false;
        /// Smallest and largest simulated over measured ordinate − 1 that is tolerated at any point.
        tolerance: [f64; 2], ordered;
        /// Why this much is tolerated: shown beside the errors.
        reason: Option<String> = None;
        /// What is assumed of the body: shown beside the errors.
        assumed: Option<String> = None;
        /// Which measurements of the same source were not looked at: shown beside the errors.
        held_back: Option<String> = None;
        /// Name of the picture that it is drawn in.
        plot: String;
        /// Simulations. Runs of one name are one, each for other lines of the table.
        run: Vec<Run>, some;
        /// Names of two simulations between which the measured ordinates are expected. They are compared as one: what of
        /// the band is nearest to the measured ordinate counts as simulated.
        band: Option<[String; 2]> = None;
    }
}

program::table! {
    /// A quantity that a simulated state has in common with a measured line.
    #[derive(Clone, Debug)]
    pub struct Condition {
        /// Title of the measured column.
        measured: String;
        /// Column of the simulation, in the unit of the measured one.
        simulated: String;
        /// Whether the simulated quantity counts from its value after the first step.
        from_first_step: bool = false;
    }
}

/// A state of a run.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Passage {
    /// The last.
    Last,
    /// Where the ordinate first has a maximum along the run, as the pressure of a wall that buckles.
    Peak,
    /// Where the ordinate has its first minimum after that maximum.
    Valley,
}

program::table! {
    /// A simulation of a row.
    #[derive(Clone, Debug)]
    pub struct Run {
        /// The name in tables and pictures.
        name: String;
        /// The steps: report.json or steps.jsonl, relative to the file.
        steps: PathBuf;
        /// Entries that the lines must have that it simulates, by the titles of columns, beside those of the row.
        #[schemars(with = "BTreeMap<String, serde_json::Value>")]
        r#where: BTreeMap<String, toml::Value> = BTreeMap::new();
        /// Whether parameters of it come from these measurements.
        fitted: bool = false;
    }
}

/// The rule of two numbers of which the first is smaller.
fn ordered<T: Numbers>(at: &KeyPath, range: &T) -> Result<(), Misfit> {
    match range.numbers()[..] {
        [from, to] if from >= to => {
            Err(misfit!(at.clone(), " = [{from}, {to}]: expected the smaller number first"))
        }
        _ => Ok(()),
    }
}

impl Config {
    /// Compares every run of every row; paths are relative to `folder`.
    pub fn compare(&self, folder: &Path) -> Result<Vec<Comparison>> {
        ensure!(!self.row.is_empty(), "no [[row]]: there is nothing to compare");
        self.check_ranges(&KeyPath::default())?;
        let compared =
            |row: &Row| row.compared(folder).with_context(|| format!("[[row]] \"{}\"", row.name));
        Ok(self.row.iter().map(compared).collect::<Result<Vec<_>>>()?.concat())
    }
}
