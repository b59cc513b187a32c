//! Tables for spreadsheets and pandas.

use std::path::Path;

use anyhow::{Context, Result};

/// What a spreadsheet takes for the beginning of a formula.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// Writes rows with commas. Names that people chose are never a formula of a spreadsheet: a space comes before one that
/// begins like that and is no number. Programs that read tables drop it.
pub fn write(path: &Path, rows: impl IntoIterator<Item = Vec<String>>) -> Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    for row in rows {
        table.write_record(row.into_iter().map(plain))?;
    }
    let text = table.into_inner().context("a table in memory")?;
    Ok(mesh::io::write_atomic(path, |out| out.write_all(&text))?)
}

fn plain(cell: String) -> String {
    let is_formula = cell.starts_with(FORMULA) && cell.parse::<f64>().is_err();
    if is_formula { format!(" {cell}") } else { cell }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_formulas_and_numbers_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("table.csv");
        let names = ["=1+1", "@SUM(1)", "-x", "+a,b", "\tb", "\rc", "tip", "a=b", ""];
        let numbers = ["-1.5", "+2", "1e-3", "NaN", "-inf", "0", "", "3", "4"];
        let rows = [names, numbers].map(|row| row.map(str::to_owned).to_vec());
        write(&path, rows.clone()).expect("written");
        let text = std::fs::read_to_string(&path).expect("text");
        let mut read = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
        let read: Vec<Vec<String>> =
            read.deserialize().collect::<Result<_, _>>().expect("the same rows");
        assert!(read[0].iter().all(|cell| !cell.starts_with(FORMULA)), "{read:?}");
        assert_eq!(read[0].iter().map(|cell| cell.trim_start()).collect::<Vec<_>>(), {
            names.map(str::trim_start)
        });
        assert_eq!(read[1], rows[1]);
    }
}
