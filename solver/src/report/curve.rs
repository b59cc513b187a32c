//! What a run measured at each reported step, as a table for spreadsheets and pandas.
//!
//! `curve.csv`: a row per step; pressure and volume of each chamber and every probe, in units of
//! the SI as its header says.

use std::path::Path;

use anyhow::{Context, Result};
use measure::probe::Probe;
use reports::Step;
use serde_json::json;

use super::results::CURVE;

/// Writes the table of a run to a folder, from the `lines` of its steps.
///
/// # Errors
/// When the file cannot be written.
pub fn write(folder: &Path, lines: &[Step], probes: &[Probe]) -> Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(lines.first().map_or_else(Vec::new, |line| header(line, probes)))?;
    for line in lines {
        table.write_record(row(line, probes).into_iter().map(cell))?;
    }
    let text = table.into_inner().context("a table in memory")?;
    mesh::io::write_atomic(&folder.join(CURVE), |out| out.write_all(&text))?;
    Ok(())
}

fn header(line: &Step, probes: &[Probe]) -> Vec<String> {
    // a scene in time has no full load, of which it could be a part
    let mut titles = vec![line.load.map_or("t [s]", |_| "load [1]").to_owned()];
    for name in line.chambers.keys() {
        titles.extend([format!("{name} pressure [Pa]"), format!("{name} volume [m³]")]);
    }
    titles.extend(probes.iter().map(|probe| format!("{} [{}]", probe.name, probe.kind.unit)));
    titles
}

fn row(line: &Step, probes: &[Probe]) -> Vec<Option<f64>> {
    let mut numbers = vec![Some(line.load.unwrap_or(line.t))];
    numbers.extend(line.chambers.values().flat_map(|c| [Some(c.pressure), Some(c.volume)]));
    let measured = |probe: &Probe| *line.probes.as_ref()?.get(&probe.name)?;
    numbers.extend(probes.iter().map(measured));
    numbers
}

/// A number that is not finite leaves its cell empty.
fn cell(number: Option<f64>) -> String {
    let number = number.filter(|number| number.is_finite());
    number.map_or_else(String::new, |number| json!(number).to_string())
}
