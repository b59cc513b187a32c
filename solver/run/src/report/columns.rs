//! Numbers of runs by the names of their columns.

use std::iter::once;
use std::path::Path;

use anyhow::{Context, Result, anyhow, ensure};
use measure::written::proposed;
use mechanics::schedule::Expression;
use mesh::Vec3;
use serde::Deserialize;
use serde_json::Value;

use super::results::STEPS;

/// The rows of a run: lines of a history.jsonl or steps.jsonl, the steps of a report.json, or the
/// runs in a file of compare.
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

/// The state at rest of the run of which [`rows`] are in a file: in the report.json, or in that beside a steps.jsonl.
/// None where the report does not have it.
pub fn at_rest(path: &Path) -> Option<Value> {
    let report = match path.file_name()?.to_str()? {
        STEPS => path.with_file_name("report.json"),
        _ => path.to_owned(),
    };
    let text = report.is_file().then(|| mesh::io::read_text(&report).ok()).flatten()?;
    serde_json::from_str::<Table>(&text).ok()?.rest
}

/// The report of a simulation, or a file of compare. Columns of its rows have the names that users give.
#[derive(Deserialize)]
struct Table {
    rest: Option<Value>,
    #[serde(alias = "steps", alias = "runs")]
    rows: Option<Vec<Value>>,
}

/// The number of a column in a row, whose names are keys, or keys joined by dots.
pub fn number(row: &Value, column: &str) -> Result<f64> {
    combined(column, &|keys| one_number(row, keys))
}

/// The number that the text of a column means: a name, which may have a factor after a star, an expression as scenes
/// have them; or a number; or several of these with " + " between them. `find` gives the number with a name.
pub fn combined(column: &str, find: &dyn Fn(&str) -> Result<f64>) -> Result<f64> {
    // a name may have a plus or a star itself
    if let Ok(number) = find(column) {
        return Ok(number);
    }
    column.split(" + ").map(|summand| product(summand.trim(), find)).sum()
}

fn product(text: &str, find: &dyn Fn(&str) -> Result<f64>) -> Result<f64> {
    let stars = text.match_indices('*').map(|(at, _)| (&text[..at], &text[at + 1..]));
    // the longest name that there is
    for (name, factor) in once((text, "1")).chain(stars.rev()) {
        if let Ok(number) = find(name) {
            let factor = constant(factor).with_context(|| format!("the factor of {text:?}"))?;
            return Ok(factor * number);
        }
    }
    // a number by itself is none of the run
    constant(text).or_else(|_| find(text.split('*').next().unwrap_or_default()))
}

/// The value of an expression that depends on nothing.
fn constant(text: &str) -> Result<f64> {
    let expression = Expression::parse(text).map_err(|what| anyhow!(proposed(&what)))?;
    let value = expression.at(Vec3::repeat(f64::NAN), f64::NAN).value;
    ensure!(value.is_finite(), "{text:?} is not a number");
    Ok(value)
}

fn one_number(row: &Value, keys: &str) -> Result<f64> {
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
    value.as_f64().with_context(|| format!("{keys:?} is {value}, not a number"))
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
    use std::f64::consts::PI;

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

    #[test]
    fn factors_are_expressions_that_depend_on_nothing() {
        let row = serde_json::json!({"angle": 2.0, "angle*2": 5.0});
        assert_eq!(number(&row, "angle*180/pi").expect("a number"), 2.0 * (180.0 / PI));
        assert_eq!(number(&row, "angle*-1e-3").expect("a number"), -2e-3);
        // the whole name, where there is one
        assert_eq!(number(&row, "angle*2*3").expect("a number"), 15.0);
        for (column, words) in [
            ("angle*t", "\"t\" is not a number"),
            ("angle*", "it ends where a value is needed"),
            ("angle*sine(1)", "did you mean `sin`?"),
        ] {
            let message = format!("{:#}", number(&row, column).expect_err(column));
            assert!(message.starts_with("the factor of") && message.contains(words), "{message}");
        }
    }
}
