//! Points of a CSV file that are laid over curves.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, Result, bail};

use crate::study::table::Table;
use run::report::columns::combined;

/// `FILE` or `FILE:X,Y`, as it was given.
#[derive(Clone, Debug)]
pub struct Points {
    path: PathBuf,
    /// Columns of the abscissa and the ordinate, as [`combined`] reads them; without, the first two.
    columns: Option<[String; 2]>,
}

impl FromStr for Points {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        let split = text.rsplit_once(':').and_then(|(path, columns)| {
            let (x, y) = columns.split_once(',')?;
            Some(Self { path: path.into(), columns: Some([x, y].map(|c| c.trim().to_owned())) })
        });
        Ok(split.unwrap_or_else(|| Self { path: text.into(), columns: None }))
    }
}

impl Points {
    /// What they are called where no label is given.
    pub fn name(&self) -> String {
        self.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
    }

    /// Reads them.
    pub fn read(&self) -> Result<Vec<(f64, f64)>> {
        let text = mesh::io::read_text(&self.path)?;
        self.parse(&text).with_context(|| self.path.display().to_string())
    }

    fn parse(&self, text: &str) -> Result<Vec<(f64, f64)>> {
        let table = Table::parse(text, &BTreeMap::new())?;
        let [x, y] = match (&self.columns, &table.titles[..]) {
            (Some(named), _) => named.clone(),
            (None, [x, y, others @ ..]) => {
                if !others.is_empty() {
                    let path = self.path.display();
                    log::info!("{path}: x is \"{x}\", y is \"{y}\"; {path}:X,Y names others");
                }
                [x.clone(), y.clone()]
            }
            (None, titles) => bail!("one column ({}): expected x and y", titles.join(", ")),
        };
        let point = |line: usize| {
            let number = |title: &str| table.number(line, title);
            Ok((combined(&x, &number)?, combined(&y, &number)?))
        };
        (0..table.lines()).map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "# by hand\nforce [N], angle*2, pressure [Pa]\n1, 10, 2e3\n2, 20, 4e3\n";

    fn read(given: &str, text: &str) -> Result<Vec<(f64, f64)>> {
        given.parse::<Points>().expect("never fails").parse(text)
    }

    #[test]
    fn columns_are_the_first_two_or_named() {
        let first = read("a.csv", TABLE).expect("sound");
        assert_eq!(first, [(1.0, 10.0), (2.0, 20.0)]);
        let named = read("a.csv:pressure [Pa]*1e-3,angle*2", TABLE).expect("sound");
        assert_eq!(named, [(2.0, 10.0), (4.0, 20.0)]);
        let sum = read("a.csv:force [N],force [N]*1/4 + angle*2", TABLE).expect("sound");
        assert_eq!(sum, [(1.0, 10.25), (2.0, 20.5)]);
    }

    #[test]
    fn what_is_no_table_of_points_is_named() {
        for (given, text, words) in [
            ("a.csv:pressur,angle*2", TABLE, "no column \"pressur\"; there are: \"force [N]\""),
            ("a.csv:force [N]*x,angle*2", TABLE, "the factor of \"force [N]*x\""),
            ("a.csv", "x, y\n1, two\n", "line 2: \"y\" is \"two\""),
            ("a.csv", "x, y\n", "the table has no line"),
            ("a.csv", "x\n1\n", "one column (x)"),
        ] {
            let error = read(given, text).expect_err(given);
            assert!(format!("{error:#}").contains(words), "{error:#}");
        }
    }
}
