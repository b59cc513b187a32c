//! What was measured: a table or a value of a probe, the mass of a body, or the thickness of a wall.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail, ensure};
use program::table::Range;
use program::{KeyPath, misfit};
use scene::Scene;
use scene::config::beside;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::shape::Shape;
use crate::study::table::{Table, unit};
use crate::units;

/// Two times are the same when they differ by less than this part of the last.
const SAME: f64 = 1e-6;

program::table! {
    /// Measurements of one probe, or of the body.
    #[derive(Clone, Debug)]
    pub struct ExperimentConfig {
        /// The name in tables and pictures.
        name: String;
        /// The scene, relative to the file.
        scene: PathBuf;
        /// The probe of the scene that was measured ...
        probe: Option<String> = None;
        /// ... or the point of the boundary [m], or near it, from which a gauge measured the wall straight in ...
        gauge: Option<[f64; 3]> = None, Range::FINITE.unit("m");
        /// ... or whether the whole body was weighed: its silicone, without inlets, tubes and sheets.
        weighed: bool = false;
        /// Measured table (CSV) of a probe, relative to the file ...
        measured: Option<PathBuf> = None;
        /// ... with the entries that its lines must have, by the titles of columns, ...
        #[schemars(with = "BTreeMap<String, serde_json::Value>")]
        r#where: BTreeMap<String, toml::Value> = BTreeMap::new();
        /// ... and the titles of the measured columns, with their unit: one, or several for repeated trials.
        columns: Vec<String> = Vec::new();
        /// The one measured value, in place of a table, in the unit of the probe, kg or m.
        value: Option<f64> = None, Range::FINITE;
        /// Standard uncertainty of a measurement, in the unit of the columns or of the value.
        uncertainty: f64, Range::POSITIVE;
        /// When.
        time: Option<Time> = None => "the end of the scene";
    }
}

impl ExperimentConfig {
    pub(super) fn title(&self) -> KeyPath {
        KeyPath::list("experiment").named(&self.name)
    }
}

/// At which t of the scene.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a time [s], or the title of a column")]
pub enum Time {
    /// All lines [s].
    At(f64),
    /// What a column says, by its title.
    Column(String),
}

/// Measurements of one probe, in SI.
pub struct Experiment {
    /// As it was written.
    pub config: ExperimentConfig,
    /// Index of its scene.
    pub(super) scene: usize,
    /// What was measured.
    pub(super) quantity: Quantity,
    /// Unit of the column, and what one is in that of the probe.
    pub unit: (String, f64),
    /// Measurements.
    pub points: Vec<Point>,
    /// Place of the first of them among those of all experiments.
    pub first: usize,
}

/// What is measured of a scene.
pub(super) enum Quantity {
    /// The probe with an index.
    Probe(usize),
    /// Of the body at rest.
    Shape(Shape),
}

/// A measurement.
pub struct Point {
    /// Time step at whose end it was made, counted from 1.
    pub(super) step: usize,
    /// t there [s].
    pub t: f64,
    /// In the unit of the probe.
    pub measured: f64,
}

impl Experiment {
    pub(super) fn read(
        own: ExperimentConfig,
        path: &Path,
        (index, scene): (usize, &Scene),
        first: usize,
    ) -> Result<Self> {
        let (quantity, wanted) = Quantity::of(&own, scene)?;
        let times = scene.times();
        let end = times[times.len() - 1];
        let (unit, measured) = match (&own.measured, own.value) {
            (Some(table), None) => table_of(&own, &beside(path, table), wanted, end)?,
            (None, Some(value)) => {
                let time = match own.time {
                    None => end,
                    Some(Time::At(time)) => time,
                    Some(Time::Column(_)) => bail!("time: a value has a time [s], not a column"),
                };
                ((wanted.to_owned(), 1.0), vec![(time, value)])
            }
            _ => bail!("expected either measured, a table of a probe, or value"),
        };
        let point = |(t, measured): (f64, f64)| {
            let step = step_at(t, &times)?;
            Ok(Point { step, t: times[step - 1], measured: measured * unit.1 })
        };
        let points = measured.into_iter().map(point).collect::<Result<Vec<_>>>()?;
        let is_one = matches!(quantity, Quantity::Probe(_)) || points.len() == 1;
        ensure!(is_one, "{} masses or gauges; expected one", points.len());
        Ok(Self { config: own, scene: index, quantity, unit, points, first })
    }
}

impl Quantity {
    /// What an experiment measures, and its unit.
    fn of(own: &ExperimentConfig, scene: &Scene) -> Result<(Self, &'static str)> {
        let name = match (&own.probe, own.gauge, own.weighed) {
            (Some(name), None, false) => name,
            (None, Some(at), false) => return Ok((Self::Shape(Shape::gauge(scene, at)?), "m")),
            (None, None, true) => return Ok((Self::Shape(Shape::mass(scene)?), "kg")),
            _ => bail!("expected one of probe, gauge and weighed = true"),
        };
        let names: Vec<&str> = scene.config.probe.iter().map(|probe| probe.name()).collect();
        let Some(probe) = names.iter().position(|own| own == name) else {
            bail!(misfit!(
                KeyPath::of("probe"),
                " = \"{name}\": the scene has no [[probe]] of this name; there are: {}",
                if names.is_empty() { "none".to_owned() } else { names.join(", ") }
            ));
        };
        Ok((Self::Probe(probe), scene.config.probe[probe].kind().unit))
    }
}

/// A unit as a table writes it, and what one is in the unit that is wanted.
type MeasuredIn = (String, f64);

/// The unit of a table, and the times and numbers of its lines.
fn table_of(
    own: &ExperimentConfig,
    path: &Path,
    wanted: &str,
    end: f64,
) -> Result<(MeasuredIn, Vec<(f64, f64)>)> {
    let table = Table::read(path, &own.r#where)?;
    let first = own.columns.first();
    let first =
        first.ok_or_else(|| misfit!(KeyPath::of("columns"), " = []: expected one or more"))?;
    let unit = in_unit(first, wanted)?;
    let mut found = Vec::new();
    for title in &own.columns {
        ensure!(
            in_unit(title, wanted)? == unit,
            misfit!(KeyPath::of("columns"), " = {:?}: expected one unit", own.columns)
        );
        let times = match &own.time {
            Some(Time::Column(title)) => table.numbers(title)?,
            Some(Time::At(t)) => vec![*t; table.lines()],
            None => vec![end; table.lines()],
        };
        found.extend(times.into_iter().zip(table.numbers(title)?));
    }
    Ok((unit, found))
}

/// The unit in the title of a column, and what one is in the unit of a probe.
fn in_unit(title: &str, wanted: &str) -> Result<(String, f64)> {
    let own = unit(title)
        .with_context(|| format!("the column \"{title}\" has no unit, as in \"{title} [mm]\""))?;
    let factor = units::factor(own, wanted).with_context(|| format!("the column \"{title}\""))?;
    Ok((own.to_owned(), factor))
}

/// The time step that ends at t, counted from 1.
fn step_at(t: f64, times: &[f64]) -> Result<usize> {
    let same = |end: &f64| (end - t).abs() <= SAME * times[times.len() - 1];
    times.iter().position(same).map(|n| n + 1).ok_or_else(|| {
        let ends: Vec<String> = times.iter().take(12).map(|t| format!("{t}")).collect();
        let more = if times.len() > 12 { ", …" } else { "" };
        anyhow!(
            "measured at t = {t} s, where no time step of the scene ends; they end at {}{more} s: \
             set `at` or `steps` in [time]",
            ends.join(", ")
        )
    })
}
