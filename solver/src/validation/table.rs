//! Measured tables: a line of titles with units, then a line per point, separated by commas.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, ensure};

/// A measured table as text, by the titles of its columns.
pub struct Table {
    titles: Vec<String>,
    lines: Vec<Vec<String>>,
}

impl Table {
    /// Reads a table, and keeps the lines that have all the entries in `wanted`.
    ///
    /// # Errors
    /// When the file is no table, lacks a column, or no line is left.
    pub fn read(path: &Path, wanted: &BTreeMap<String, toml::Value>) -> Result<Self> {
        let text = mesh::io::read_text(path)?;
        Self::parse(&text, wanted).with_context(|| path.display().to_string())
    }

    fn parse(text: &str, wanted: &BTreeMap<String, toml::Value>) -> Result<Self> {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let titles = reader.headers()?.iter().map(str::to_owned).collect();
        let lines = reader.records().map(|r| Ok(r?.iter().map(str::to_owned).collect()));
        let mut table = Self { titles, lines: lines.collect::<Result<_>>()? };
        for (title, value) in wanted {
            let column = table.column(title)?;
            table.lines.retain(|line| same(&line[column], value));
            ensure!(!table.lines.is_empty(), "no line has {value} in the column \"{title}\"");
        }
        Ok(table)
    }

    fn column(&self, title: &str) -> Result<usize> {
        self.titles.iter().position(|t| t == title).with_context(|| {
            format!("no column \"{title}\"; there are: \"{}\"", self.titles.join("\", \""))
        })
    }

    /// The numbers of a column.
    ///
    /// # Errors
    /// When there is no such column, or an entry is no number.
    pub fn numbers(&self, title: &str) -> Result<Vec<f64>> {
        let column = self.column(title)?;
        let number = |line: &Vec<String>| {
            let text = &line[column];
            text.parse().with_context(|| format!("\"{title}\": \"{text}\" is not a number"))
        };
        self.lines.iter().map(number).collect()
    }
}

/// Whether an entry is a text or a number that a configuration gives.
fn same(entry: &str, value: &toml::Value) -> bool {
    match value {
        toml::Value::String(text) => entry == text,
        toml::Value::Integer(number) => entry.parse() == Ok(*number as f64),
        toml::Value::Float(number) => entry.parse() == Ok(*number),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DROPS: &str = "load [N], marker, drop [mm]\n0, top, 6.5\n0.5, top, 17\n0.5, left, x\n";

    fn keeping(title: &str, value: impl Into<toml::Value>) -> Result<Table> {
        Table::parse(DROPS, &BTreeMap::from([(title.to_owned(), value.into())]))
    }

    #[test]
    fn lines_are_chosen_by_text_and_by_number() {
        let top = keeping("marker", "top").expect("lines");
        assert_eq!(top.numbers("drop [mm]").expect("numbers"), [6.5, 17.0]);
        let unloaded = keeping("load [N]", 0).expect("lines");
        assert_eq!(unloaded.numbers("drop [mm]").expect("numbers"), [6.5]);
    }

    #[test]
    fn what_is_missing_is_named() {
        let why = |table: Result<Table>, title: &str| {
            let numbers = table.and_then(|t| t.numbers(title));
            format!("{:#}", numbers.expect_err("not there"))
        };
        assert!(why(keeping("marker", "right"), "drop [mm]").contains("\"right\""));
        assert!(why(keeping("side", "top"), "drop [mm]").contains("\"marker\""));
        assert!(why(keeping("marker", "left"), "drop [mm]").contains("\"x\""));
    }
}
