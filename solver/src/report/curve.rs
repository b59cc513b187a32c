//! What a run measured at each reported step, as a table for spreadsheets and pandas.
//!
//! `curve.csv`: a row per step; pressure and volume of each chamber and every probe, in units of
//! the SI as its header says.

use std::path::Path;

use anyhow::{Context, Result};
use measure::probe::Probe;
use serde_json::Value;

/// Name of the table.
pub const CURVE: &str = "curve.csv";

/// A column: its header, and the keys of its number in a line of `steps.jsonl`.
type Column = (String, Vec<String>);

/// Writes the table of a run to a folder, from the `lines` of its steps.
///
/// # Errors
/// When the file cannot be written.
pub fn write(folder: &Path, lines: &[Value], probes: &[Probe]) -> Result<()> {
    let columns = lines.first().map_or_else(Vec::new, |line| columns(line, probes));
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(columns.iter().map(|(header, _)| header))?;
    for line in lines {
        table.write_record(columns.iter().map(|(_, keys)| cell(line, keys)))?;
    }
    let text = table.into_inner().context("a table in memory")?;
    mesh::io::write_atomic(&folder.join(CURVE), |out| out.write_all(&text))?;
    Ok(())
}

fn columns(line: &Value, probes: &[Probe]) -> Vec<Column> {
    let column = |header: String, keys: &[&str]| -> Column {
        (header, keys.iter().map(|&key| key.to_owned()).collect())
    };
    // a scene in time has no full load, of which it could be a part
    let mut columns = vec![match line.get("load") {
        Some(_) => column("load [1]".into(), &["load"]),
        None => column("t [s]".into(), &["t"]),
    }];
    for name in line["chambers"].as_object().into_iter().flat_map(|chambers| chambers.keys()) {
        for (key, unit) in [("pressure", "Pa"), ("volume", "m³")] {
            columns.push(column(format!("{name} {key} [{unit}]"), &["chambers", name, key]));
        }
    }
    for probe in probes {
        let header = format!("{} [{}]", probe.name, probe.kind.unit);
        columns.push(column(header, &["probes", &probe.name]));
    }
    columns
}

fn cell(line: &Value, keys: &[String]) -> String {
    let value = keys.iter().try_fold(line, |value, key| value.get(key));
    value.filter(|value| value.is_number()).map_or_else(String::new, Value::to_string)
}
