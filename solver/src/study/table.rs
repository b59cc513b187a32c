//! Measured tables: a line of titles with units, then a line per point, separated by commas. Lines that begin with # are
//! comments.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use csv::StringRecord;
use program::{KeyPath, Misfit, misfit};

/// A measured table as text, by the titles of its columns.
pub struct Table {
    /// Of all columns.
    pub titles: Vec<String>,
    lines: Vec<StringRecord>,
}

impl Table {
    /// Reads a table, and keeps the lines that have all the entries in `wanted`.
    pub fn read(path: &Path, wanted: &BTreeMap<String, toml::Value>) -> Result<Self> {
        let text = mesh::io::read_text(path)?;
        Self::parse(&text, wanted).with_context(|| path.display().to_string())
    }

    /// [`Self::read`] of a text.
    pub fn parse(text: &str, wanted: &BTreeMap<String, toml::Value>) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let titles = reader.headers()?.iter().map(str::to_owned).collect();
        let lines = reader.records().collect::<csv::Result<Vec<_>>>()?;
        ensure!(
            !lines.is_empty(),
            "the table has no line; expected a line of titles with units, then a line per point"
        );
        let mut table = Self { titles, lines };
        for (title, value) in wanted {
            let column = table.column(title)?;
            table.lines.retain(|line| same(&line[column], value));
            ensure!(!table.lines.is_empty(), "no line has {value} in the column \"{title}\"");
        }
        Ok(table)
    }

    fn column(&self, title: &str) -> Result<usize> {
        let all = || format!("there are: \"{}\"", self.titles.join("\", \""));
        let find = |title: &str| self.titles.iter().position(|t| t == title);
        // a title that has no unit is given one where it is used
        if let Some(column) = find(title).or_else(|| find(quantity(title))) {
            return Ok(column);
        }
        match self.titles.iter().find(|t| quantity(t) == quantity(title)) {
            Some(other) => {
                bail!("no column \"{title}\", but \"{other}\": mind the unit; {}", all())
            }
            None => bail!("no column \"{title}\"; {}", all()),
        }
    }

    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.lines.len()
    }

    /// The number in a line and in the column with a title.
    pub fn number(&self, line: usize, title: &str) -> Result<f64> {
        let line = &self.lines[line];
        let text = &line[self.column(title)?];
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.with_context(|| {
            let number = line.position().map_or(0, csv::Position::line);
            format!("line {number}: \"{title}\" is \"{text}\"; expected a finite number")
        })
    }

    /// The numbers of a column, by its title with a unit, which is added to one that has none.
    pub fn numbers(&self, title: &str) -> Result<Vec<f64>> {
        self.column(title)?;
        ensure!(
            quantity(title) != title,
            "the column \"{title}\" has no unit; expected \"{title} [mm]\", or another one"
        );
        (0..self.lines()).map(|line| self.number(line, title)).collect()
    }
}

/// The rule of a list of a file that has an entry or more.
#[allow(clippy::ptr_arg, reason = "the rule of a key of this type")]
pub fn some<T>(at: &KeyPath, list: &Vec<T>) -> Result<(), Misfit> {
    match list.is_empty() {
        true => Err(misfit!(at.clone(), " = []: expected one or more")),
        false => Ok(()),
    }
}

/// A title without its unit, such as `height` of `height [mm]`.
fn quantity(title: &str) -> &str {
    match title.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((quantity, _)) => quantity.trim(),
        None => title,
    }
}

/// The unit in a title, such as `mm` of `height [mm]`.
pub fn unit(title: &str) -> Option<&str> {
    title.strip_suffix(']')?.rsplit_once('[').map(|(_, unit)| unit.trim())
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
        let no_number = why(keeping("marker", "left"), "drop [mm]");
        assert!(no_number.contains("line 4") && no_number.contains("\"x\""), "{no_number}");
        let unit = why(keeping("marker", "top"), "drop [m]");
        assert!(unit.contains("but \"drop [mm]\": mind the unit"), "{unit}");
        assert!(why(keeping("marker", "top"), "marker").contains("no unit"));
    }
}
