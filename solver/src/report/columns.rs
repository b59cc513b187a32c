//! Numbers of runs by the names of their columns.

use std::path::Path;

use anyhow::{Context, Result};
use serde::Deserialize;
use serde_json::Value;

/// The rows of a run: lines of a history.jsonl or steps.jsonl, the steps of a report.json, or the
/// runs in a file of compare.
///
/// # Errors
/// When the file cannot be read or has no rows.
pub fn rows(path: &Path) -> Result<Vec<Value>> {
    let text = mesh::io::read_text(path)?;
    let context = || path.display().to_string();
    if mesh::io::extension(path) == "jsonl" {
        let lines = text.lines().enumerate();
        let row = |(i, line): (usize, &str)| {
            serde_json::from_str(line)
                .with_context(|| format!("{}: line {}", path.display(), i + 1))
        };
        return lines.map(row).collect();
    }
    let table: Table = serde_json::from_str(&text).with_context(context)?;
    table.rows.with_context(|| {
        format!(
            "{}: no \"steps\" or \"runs\": expected a report.json of simulate, a history.jsonl of \
             optimize or a file of compare",
            path.display()
        )
    })
}

/// The report of a simulation, or a file of compare. Columns of its rows have the names that users give.
#[derive(Deserialize)]
struct Table {
    #[serde(alias = "steps", alias = "runs")]
    rows: Option<Vec<Value>>,
}

/// The number of a column in a row: a key, or keys joined by dots, and a factor after a star; or
/// several of these with " + " between them.
///
/// # Errors
/// When the row has no such number; the message lists what it has.
pub fn number(row: &Value, column: &str) -> Result<f64> {
    column.split(" + ").map(|summand| one_number(row, summand.trim())).sum()
}

fn one_number(row: &Value, column: &str) -> Result<f64> {
    let (keys, factor) = column.split_once('*').unwrap_or((column, "1"));
    let factor: f64 = factor.parse().with_context(|| format!("the factor of {column:?}"))?;
    let (mut value, mut left) = (row, keys);
    while !left.is_empty() {
        let (key, rest) = first_key(value, left);
        let next = match value {
            Value::Array(items) => key.parse().ok().and_then(|i: usize| items.get(i)),
            _ => value.get(key),
        };
        value =
            next.with_context(|| format!("no {key:?} of {keys:?}; there are: {}", known(value)))?;
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
    fn columns_are_added() {
        let row = serde_json::json!({"terms": {"head stays": 2.0, "throat": 3.0}, "a+b": 1.0});
        let sum = number(&row, "terms.head stays + terms.throat*10").expect("numbers");
        assert_eq!(sum, 32.0);
        assert_eq!(number(&row, "a+b").expect("a key"), 1.0);
        let text = number(&row, "terms.throat + terms.feet").expect_err("no such key").to_string();
        assert!(text.contains("no \"feet\""), "{text}");
    }
}
