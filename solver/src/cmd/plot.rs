//! `solver plot`: numbers of runs as curves.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::plot::{Axes, Series, Style, draw};

/// Columns that older programs called otherwise: the old name and the one of today.
const RENAMED: [[&str; 2]; 3] = [
    ["walls", "chambers"],
    ["energies.pressure", "energies.chamber"],
    ["force_balance.pressure", "force_balance.chamber"],
];

/// Draw numbers of one or more runs against each other, as SVG
///
/// A run is a history.jsonl of optimize or steps.jsonl of simulate, a row per line, a report.json of
/// simulate, a row per load step, or a file of compare, a row per run. A column is a key, or keys joined by dots:
/// `objective`, `terms.throat`, `reactions.top.2`. A factor may follow a star,
/// as in `mean_displacement.throat*1e3`. Without --x, rows are counted.
/// Rows without the number are left out.
#[derive(clap::Args)]
pub struct Arguments {
    /// Runs: one curve each, for every --y
    #[arg(required = true)]
    runs: Vec<PathBuf>,
    /// SVG file to write
    #[arg(short, long)]
    output: PathBuf,
    /// Column of the abscissa
    #[arg(long)]
    x: Option<String>,
    /// Columns of the ordinate
    #[arg(long, required = true, value_delimiter = ',')]
    y: Vec<String>,
    /// Names of the curves, in their order
    #[arg(long, value_delimiter = ',')]
    labels: Vec<String>,
    /// Written at the abscissa
    #[arg(long)]
    x_title: Option<String>,
    /// Written at the ordinate
    #[arg(long)]
    y_title: Option<String>,
    /// Logarithmic ordinate
    #[arg(long)]
    log: bool,
    /// Logarithmic abscissa
    #[arg(long)]
    log_x: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let curves = arguments.runs.len() * arguments.y.len();
    ensure!(
        arguments.labels.is_empty() || arguments.labels.len() == curves,
        "--labels names {} curves, there are {curves}",
        arguments.labels.len()
    );
    let mut series: Vec<Series> = Vec::new();
    for path in &arguments.runs {
        let rows = rows(path)?;
        for y in &arguments.y {
            let turn = series.len();
            let label =
                arguments.labels.get(turn).cloned().unwrap_or_else(|| match arguments.runs.len() {
                    1 => y.clone(),
                    _ => format!("{}: {y}", path.display()),
                });
            let points = points(&rows, arguments.x.as_deref(), y)
                .with_context(|| path.display().to_string())?;
            series.push(Series { label: Some(label), points, style: Style::Dotted(2), turn });
        }
    }
    let title =
        |title: &Option<String>, column: &str| title.clone().unwrap_or_else(|| column.to_owned());
    let axes = Axes {
        x: title(&arguments.x_title, arguments.x.as_deref().unwrap_or("row")),
        y: title(&arguments.y_title, &arguments.y.join(", ")),
        log_x: arguments.log_x,
        log_y: arguments.log,
    };
    draw(&arguments.output, &axes, &series)
}

/// The rows of a run.
fn rows(path: &Path) -> Result<Vec<Value>> {
    let text = mesh::io::read_text(path)?;
    let context = || path.display().to_string();
    if path.extension().is_some_and(|e| e == "jsonl") {
        let lines = text.lines().enumerate();
        let row = |(i, line): (usize, &str)| {
            serde_json::from_str(line)
                .with_context(|| format!("{}: line {}", path.display(), i + 1))
        };
        return lines.map(row).collect();
    }
    let report: Value = serde_json::from_str(&text).with_context(context)?;
    match report.get("steps").or_else(|| report.get("runs")) {
        Some(Value::Array(rows)) => Ok(rows.clone()),
        _ => bail!(
            "{}: no \"steps\" or \"runs\": expected a report.json of simulate, a history.jsonl of \
             optimize or a file of compare",
            path.display()
        ),
    }
}

/// The rows that have both numbers: before surfaces meet there is no gap, for one.
fn points(rows: &[Value], x: Option<&str>, y: &str) -> Result<Vec<(f64, f64)>> {
    let point = |(i, row): (usize, &Value)| {
        let x = x.map_or(Ok(i as f64), |x| number(row, x))?;
        Ok((x, number(row, y)?))
    };
    let (points, missing): (Vec<_>, Vec<_>) =
        rows.iter().enumerate().map(point).partition(Result::is_ok);
    match missing.into_iter().next() {
        Some(error) if points.is_empty() => error.map(|_: (f64, f64)| Vec::new()),
        _ => points.into_iter().collect(),
    }
}

/// The number of a column in a row.
fn number(row: &Value, column: &str) -> Result<f64> {
    let (keys, factor) = column.split_once('*').unwrap_or((column, "1"));
    let factor: f64 = factor.parse().with_context(|| format!("the factor of {column:?}"))?;
    let (mut value, mut left) = (row, keys);
    while !left.is_empty() {
        let (key, rest) = first_key(value, left);
        let next = match value {
            Value::Array(items) => key.parse().ok().and_then(|i: usize| items.get(i)),
            _ => value.get(key),
        };
        value = next.with_context(|| {
            format!("no {key:?} of {keys:?}; there are: {}{}", known(value), renamed(keys))
        })?;
        left = rest;
    }
    let number = value.as_f64().with_context(|| format!("{keys:?} is {value}, not a number"))?;
    Ok(factor * number)
}

/// The first of keys joined by dots, and the others. A key may have dots itself, as tags
/// of one body of several do: the longest that the value has.
fn first_key<'a>(value: &Value, keys: &'a str) -> (&'a str, &'a str) {
    let dots = keys.match_indices('.').map(|(at, _)| (&keys[..at], &keys[at + 1..]));
    let mut splits = std::iter::once((keys, "")).chain(dots.rev());
    let shortest = keys.split_once('.').unwrap_or((keys, ""));
    splits.find(|(key, _)| value.get(key).is_some()).unwrap_or(shortest)
}

/// Where a column of older results is now, and the other way round.
fn renamed(keys: &str) -> String {
    for [old, new] in RENAMED {
        let begins = |with: &str| {
            let rest = keys.strip_prefix(with)?;
            (rest.is_empty() || rest.starts_with('.')).then_some(rest)
        };
        if let Some(rest) = begins(old) {
            return format!("; {keys:?} is now \"{new}{rest}\"");
        }
        if let Some(rest) = begins(new) {
            return format!("; in results of older programs it is \"{old}{rest}\"");
        }
    }
    String::new()
}

/// What a value holds.
fn known(value: &Value) -> String {
    match value {
        Value::Object(map) => map.keys().cloned().collect::<Vec<_>>().join(", "),
        Value::Array(items) => format!("0 to {}", items.len().saturating_sub(1)),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_may_have_dots_themselves() {
        let row = serde_json::json!({"moved": {"grip.face": [1.0, 2.0], "grip": {"face": [3.0]}}});
        assert_eq!(number(&row, "moved.grip.face.1*10").expect("a number"), 20.0);
        let text = number(&row, "moved.grasp.face").expect_err("no such key").to_string();
        assert!(text.contains("no \"grasp\"") && text.contains("grip.face"), "{text}");
    }

    #[test]
    fn columns_of_older_programs_are_named_anew() {
        let old = serde_json::json!({"walls": {"left": {"pressure": 1.0}}, "energies": {"pressure": 2.0}});
        let new = serde_json::json!({"chambers": {"left": {"pressure": 1.0}}, "energies": {"chamber": 2.0}});
        let why = |row, column| number(row, column).expect_err("no such key").to_string();
        let now = "\"walls.left.pressure\" is now \"chambers.left.pressure\"";
        assert!(why(&new, "walls.left.pressure").contains(now));
        assert!(why(&new, "energies.pressure*2").contains("is now \"energies.chamber\""));
        let before = "in results of older programs it is \"walls.left.pressure\"";
        assert!(why(&old, "chambers.left.pressure").contains(before));
        assert!(!why(&old, "wallsome").contains("now"));
    }
}
