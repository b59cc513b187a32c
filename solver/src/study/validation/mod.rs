//! Simulations beside measurements: the simulated value of each measured point, and its error.

pub mod table;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::report::columns::{number, rows};
use table::Table;

/// Two values of a condition are the same when they differ by less than this part of the larger.
const SAME: f64 = 1e-6;
/// Points that a polynomial goes through, at most.
const NEAREST: usize = 4;

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
    /// What a simulated state must have in common with a measured line.
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
    /// Name of the picture that it is drawn in.
    pub plot: String,
    /// Simulations.
    pub run: Vec<Run>,
}

/// A quantity that a simulated state has in common with a measured line.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// Title of the measured column.
    pub measured: String,
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
}

/// A simulation of a row.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// The name in tables and pictures.
    pub name: String,
    /// The steps: report.json or steps.jsonl, relative to the file.
    pub steps: PathBuf,
    /// Whether parameters of it come from these measurements.
    #[serde(default)]
    pub fitted: bool,
}

/// A measured point.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Half of the bar around it.
    pub spread: f64,
    /// Values of the row's conditions.
    #[serde(skip)]
    conditions: Vec<f64>,
}

/// A simulation beside the measured points.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Name of the row.
    pub row: String,
    /// Name of the run.
    pub run: String,
    /// Whether parameters of it come from these measurements.
    pub fitted: bool,
    /// Measured points.
    pub measured: Vec<Point>,
    /// Simulated ordinates; none where the simulation has no such state.
    pub simulated: Vec<Option<f64>>,
    /// Simulated over measured ordinate − 1, where there is one: the mean.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// Unit of the ordinate, as its title has it in brackets.
    pub unit: String,
    /// Simulated less measured ordinate, in that unit: the mean.
    pub mean_difference: f64,
    /// Root of the mean square of that.
    pub rms_difference: f64,
    /// The one of the largest magnitude.
    pub largest: f64,
    /// Smallest and largest that are tolerated.
    pub tolerance: [f64; 2],
    /// Whether all points are simulated and within the tolerance.
    pub within: bool,
}

impl Config {
    /// Compares every run of every row; paths are relative to `folder`.
    ///
    /// # Errors
    /// When a table or a run cannot be read or lacks a column, or when a run has none of the
    /// measured states.
    pub fn compare(&self, folder: &Path) -> Result<Vec<Comparison>> {
        ensure!(!self.row.is_empty(), "no [[row]]: there is nothing to compare");
        let of_row = |row: &Row| {
            row.check()?;
            let measured = row.measured(folder)?;
            let compare = |run| row.compare(run, &measured, folder);
            row.run.iter().map(compare).collect::<Result<Vec<_>>>()
        };
        let found: Result<Vec<_>> = self
            .row
            .iter()
            .map(|row| of_row(row).with_context(|| format!("[[row]] \"{}\"", row.name)))
            .collect();
        Ok(found?.concat())
    }
}

impl Row {
    /// Refuses a row that compares nothing, or whose bounds nothing can meet.
    fn check(&self) -> Result<()> {
        ensure!(!self.y.is_empty(), "y: no column; expected one or more titles of the table");
        ensure!(!self.run.is_empty(), "no [[row.run]]: expected one simulation or more");
        ensure!(!self.condition.is_empty(), "condition: none; expected one or more");
        let ordered = |name: &str, [from, to]: [f64; 2]| {
            ensure!(from < to, "{name} = [{from}, {to}]: expected the smaller number first");
            Ok(())
        };
        self.range.map_or(Ok(()), |range| ordered("range", range))?;
        ordered("tolerance", self.tolerance)
    }

    fn measured(&self, folder: &Path) -> Result<Vec<Point>> {
        let path = folder.join(&self.measured);
        let table = Table::read(&path, &self.lines)?;
        let column =
            |title: &String| table.numbers(title).with_context(|| path.display().to_string());
        let columns = |titles: &[String]| titles.iter().map(column).collect::<Result<Vec<_>>>();
        let (x, trials) = (column(&self.x)?, columns(&self.y)?);
        let spread = self.spread.as_ref().map(column).transpose()?;
        let conditions: Vec<String> = self.condition.iter().map(|c| c.measured.clone()).collect();
        let conditions = columns(&conditions)?;
        let at = |values: &[Vec<f64>], i: usize| values.iter().map(|v| v[i]).collect::<Vec<_>>();
        let point = |(i, &x): (usize, &f64)| {
            let trials = at(&trials, i);
            let low = trials.iter().copied().fold(f64::INFINITY, f64::min);
            let high = trials.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            Point {
                x,
                y: trials.iter().sum::<f64>() / trials.len() as f64,
                spread: spread.as_ref().map_or(0.5 * (high - low), |s| s[i]),
                conditions: at(&conditions, i),
            }
        };
        let [from, to] = self.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let points = x.iter().enumerate().map(point).filter(|p| (from..=to).contains(&p.x));
        let points: Vec<Point> = points.collect();
        ensure!(!points.is_empty(), "{}: no line within the range", path.display());
        if let Some(zero) = points.iter().find(|p| p.y == 0.0) {
            anyhow::bail!(
                "{}: the ordinate is 0 at {} = {}: it has no relative error; leave it out by range",
                path.display(),
                self.x,
                zero.x
            );
        }
        Ok(points)
    }

    fn compare(&self, run: &Run, measured: &[Point], folder: &Path) -> Result<Comparison> {
        let path = folder.join(&run.steps);
        let states = self.states(&path).with_context(|| path.display().to_string())?;
        let find = |p: &Point| self.simulated_at(&states, &p.conditions);
        let simulated = measured.iter().map(find).collect::<Result<Vec<_>>>();
        let simulated = simulated.with_context(|| path.display().to_string())?;
        let both = || measured.iter().zip(&simulated).filter_map(|(p, s)| Some((p.y, (*s)?)));
        let errors: Vec<f64> = both().map(|(y, s)| s / y - 1.0).collect();
        let differences: Vec<f64> = both().map(|(y, s)| s - y).collect();
        ensure!(
            !errors.is_empty(),
            "{}: no measured point lies between its {} states; conditions: {}",
            path.display(),
            states.len(),
            self.condition.iter().map(|c| c.simulated.as_str()).collect::<Vec<_>>().join(", ")
        );
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let rms = |values: &[f64]| mean(&values.iter().map(|v| v * v).collect::<Vec<_>>()).sqrt();
        let largest =
            errors.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        let [low, high] = self.tolerance;
        Ok(Comparison {
            row: self.name.clone(),
            run: run.name.clone(),
            fitted: run.fitted,
            measured: measured.to_vec(),
            mean: mean(&errors),
            rms: rms(&errors),
            unit: unit_of(&self.y[0]),
            mean_difference: mean(&differences),
            rms_difference: rms(&differences),
            largest,
            tolerance: self.tolerance,
            within: errors.len() == measured.len()
                && errors.iter().all(|e| (low..=high).contains(e)),
            simulated,
        })
    }

    /// The ordinate in the state that meets the conditions; none where no state does.
    fn simulated_at(&self, states: &[(Vec<f64>, f64)], wanted: &[f64]) -> Result<Option<f64>> {
        let [wanted] = wanted else { return Ok(interpolate(states, wanted)) };
        let path: Vec<(f64, f64)> = states.iter().map(|(c, value)| (c[0], *value)).collect();
        let found = passages(&path, *wanted);
        match (&found[..], self.passage) {
            ([], _) => Ok(None),
            ([one], _) | ([one, ..], Some(Passage::First)) => Ok(Some(*one)),
            ([.., one], Some(Passage::Last)) => Ok(Some(*one)),
            (several, None) => anyhow::bail!(
                "{} states have {} = {wanted}, as the run goes back and forth; there the ordinate is {several:?}\n  \
                 add passage = \"first\" or \"last\" to the row",
                several.len(),
                self.condition[0].simulated
            ),
        }
    }

    /// Values of the conditions and of the ordinate in every state of a run.
    fn states(&self, path: &Path) -> Result<Vec<(Vec<f64>, f64)>> {
        let rows = rows(path)?;
        let column = |name: &str, from_first_step: bool| -> Result<Vec<f64>> {
            let values: Vec<f64> =
                rows.iter().map(|row| number(row, name)).collect::<Result<_>>()?;
            let zero = values.first().filter(|_| from_first_step).map_or(0.0, |v| *v);
            Ok(values.iter().map(|v| v - zero).collect())
        };
        let conditions = self.condition.iter().map(|c| column(&c.simulated, c.from_first_step));
        let conditions: Vec<_> = conditions.collect::<Result<_>>()?;
        let values = column(&self.simulated, self.from_first_step)?;
        let at = |i: usize| conditions.iter().map(|c| c[i]).collect();
        Ok(values.into_iter().enumerate().map(|(i, value)| (at(i), value)).collect())
    }
}

/// What a title has in brackets at its end: `[Pa]` of `pressure [Pa]`; else nothing.
fn unit_of(title: &str) -> String {
    let unit = title.strip_suffix(']').and_then(|title| title.rsplit_once('['));
    unit.map_or_else(String::new, |(_, unit)| unit.to_owned())
}

/// The values at `wanted` along a path of states (condition, value), one for each stretch on which the condition
/// grows or falls and passes it.
fn passages(path: &[(f64, f64)], wanted: f64) -> Vec<f64> {
    let mut path = path.to_vec();
    path.dedup_by(|a, b| same(a.0, b.0));
    if let [one] = path[..] {
        return if same(one.0, wanted) { vec![one.1] } else { Vec::new() };
    }
    let mut found: Vec<f64> = Vec::new();
    let mut start = 0;
    for end in 1..path.len() {
        let turns = |i: usize| (path[i].0 - path[i - 1].0) * (path[i + 1].0 - path[i].0) < 0.0;
        if end + 1 < path.len() && !turns(end) {
            continue;
        }
        let mut stretch = path[start..=end].to_vec();
        stretch.sort_by(|a, b| a.0.total_cmp(&b.0));
        // the state at which two stretches meet is one
        let value = polynomial(&stretch, wanted).filter(|value| found.last() != Some(value));
        found.extend(value);
        start = end;
    }
    found
}

/// The value at `wanted` between states, given by their conditions and values. States with the
/// same first condition are a curve over the others; the curves are interpolated one by one, and
/// then their values over the first condition.
fn interpolate(states: &[(Vec<f64>, f64)], wanted: &[f64]) -> Option<f64> {
    let Some((first, others)) = wanted.split_first() else {
        return states.first().map(|s| s.1);
    };
    let mut sorted: Vec<(f64, Vec<f64>, f64)> =
        states.iter().map(|(c, value)| (c[0], c[1..].to_vec(), *value)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let curves = sorted.chunk_by(|a, b| same(a.0, b.0));
    let curve = |curve: &[(f64, Vec<f64>, f64)]| {
        let states: Vec<_> = curve.iter().map(|s| (s.1.clone(), s.2)).collect();
        Some((curve[0].0, interpolate(&states, others)?))
    };
    polynomial(&curves.filter_map(curve).collect::<Vec<_>>(), *first)
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// Lagrange's polynomial through the points (x, y) that are nearest to `x`, in order of x; none
/// outside of them.
fn polynomial(points: &[(f64, f64)], x: f64) -> Option<f64> {
    if let Some(hit) = points.iter().find(|p| same(p.0, x)) {
        return Some(hit.1);
    }
    let after = points.iter().position(|p| p.0 > x).filter(|&i| i > 0)?;
    let start = after.saturating_sub(NEAREST / 2).min(points.len().saturating_sub(NEAREST));
    let near = &points[start..points.len().min(start + NEAREST)];
    let weight = |i: usize| -> f64 {
        let others = near.iter().enumerate().filter(|&(j, _)| j != i);
        others.map(|(_, p)| (x - p.0) / (near[i].0 - p.0)).product()
    };
    Some(near.iter().enumerate().map(|(i, p)| weight(i) * p.1).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// z = x³ + x y², on a grid.
    fn cubic() -> Vec<(Vec<f64>, f64)> {
        let grid = (0..5).flat_map(|i| (0..4).map(move |j| (f64::from(i), f64::from(j))));
        grid.map(|(x, y)| (vec![x, y], x * x * x + x * y * y)).collect()
    }

    #[test]
    fn cubics_of_two_conditions_are_exact() {
        for (x, y) in [(0.5, 0.25), (2.0, 1.7), (3.9, 3.0), (4.0, 0.0)] {
            let found = interpolate(&cubic(), &[x, y]).expect("inside");
            assert!((found - (x * x * x + x * y * y)).abs() < 1e-12, "{found}");
        }
    }

    /// Up to 3, back to 1, and up again to 4.
    #[test]
    fn a_path_that_turns_passes_a_value_several_times() {
        let path = [(0.0, 0.0), (2.0, 1.0), (3.0, 2.0), (1.0, 3.0), (4.0, 4.0)];
        assert_eq!(passages(&path[..3], 2.0), [1.0]);
        assert_eq!(passages(&path, 3.5).len(), 1);
        let twice = passages(&path, 2.0);
        assert_eq!((twice.len(), twice[0], twice[1]), (3, 1.0, 2.5));
        // where it turns, one state is met once
        assert_eq!(passages(&path[..4], 3.0), [2.0]);
        assert!(passages(&path, 5.0).is_empty());
        assert_eq!(passages(&[(1.0, 7.0)], 1.0), [7.0]);
    }

    #[test]
    fn nothing_is_extrapolated() {
        assert_eq!(interpolate(&cubic(), &[4.1, 1.0]), None);
        assert_eq!(interpolate(&cubic(), &[2.0, -0.1]), None);
        // two states: a line between them
        let line = [(vec![1.0], 10.0), (vec![3.0], 20.0)];
        assert_eq!(interpolate(&line, &[2.0]), Some(15.0));
        assert_eq!(interpolate(&line[..1], &[2.0]), None);
    }
}
