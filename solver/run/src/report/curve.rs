//! What a run measured at each reported step, as a table for spreadsheets and pandas.
//!
//! `curve.csv`: a row at rest, where forces balance there, and one per step; pressure and volume of each chamber and every
//! probe, in units of the SI as its header says. Numbers have twelve digits: a load of 0.1 + 0.1 + 0.1 is 0.3.

use std::path::Path;

use anyhow::Result;
use measure::probe::Probe;
use reports::Step;
use serde_json::json;

use super::results::CURVE;
use super::table;

/// Writes the table of a run to a folder, from the `lines` of its states.
pub fn write<'a>(
    folder: &Path,
    lines: impl Iterator<Item = &'a Step>,
    probes: &[Probe],
) -> Result<()> {
    let mut lines = lines.peekable();
    let header = lines.peek().map_or_else(Vec::new, |line| header(line, probes));
    let rows = lines.map(|line| row(line, probes).into_iter().map(cell).collect());
    table::write(&folder.join(CURVE), [header].into_iter().chain(rows))
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
    let rounded = number.and_then(|number| format!("{number:.11e}").parse::<f64>().ok());
    rounded.map_or_else(String::new, |number| json!(number).to_string())
}

#[cfg(test)]
mod tests {
    use super::cell;

    #[test]
    fn cells_have_twelve_digits() {
        assert_eq!(cell(Some(0.1 + 0.2)), "0.3");
        assert_eq!(cell(Some(1.0 / 3.0 * 1e-6)), "3.33333333333e-7");
        assert_eq!([cell(Some(0.0)), cell(Some(f64::NAN)), cell(None)], ["0.0", "", ""]);
    }
}
