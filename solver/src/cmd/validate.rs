//! `solver validate`: simulations beside measurements.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use program::FolderLock;
use reports::{Comparison, Validation};

use crate::plot::{Axes, Series, Style, draw};
use crate::study::validation::{Config, Row};

/// Compare simulations with measured tables
///
/// CONFIG names measured tables, the runs that belong to them, and tolerances. Writes to the
/// output folder errors.md, a table of the errors, errors.json with all points, and the
/// pictures that CONFIG asks for.
#[derive(clap::Args)]
pub struct Arguments {
    /// What is compared (TOML)
    config: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let config: Config = program::read_toml(&arguments.config)?;
    let folder = arguments.config.parent().unwrap_or(Path::new("."));
    let found = config.compare(folder).with_context(|| arguments.config.display().to_string())?;
    let _lock = FolderLock::new(&arguments.output)?;
    let table = table(&found)?;
    writeln!(program::stdout(), "{table}")?;
    let path = arguments.output.join("errors.md");
    mesh::io::write_atomic(&path, |out| out.write_all(table.as_bytes()))?;
    pictures(&config, &found, &arguments.output)?;
    let program = concat!("solver ", env!("CARGO_PKG_VERSION")).to_owned();
    let report = Validation { program, rows: found };
    program::write_json(&arguments.output.join("errors.json"), &report)
}

/// The errors in Markdown.
fn table(found: &[Comparison]) -> Result<String> {
    let mut text = String::from(
        "| measured | simulated | points | mean error | rms | largest | tolerance | |\n\
         |-|-|-|-|-|-|-|-|\n",
    );
    for one in found {
        let percent = |value: f64| format!("{:+.1} %", 100.0 * value);
        let reached = one.simulated.iter().flatten().count();
        let verdict = one.verdict();
        writeln!(
            text,
            "| {} | {} | {reached} of {} | {}, {:+.3} {} | {:.1} %, {:.3} {} | {} | {} to {} | {verdict} |",
            one.row,
            one.run,
            one.measured.len(),
            percent(one.mean),
            one.mean_difference,
            one.unit,
            100.0 * one.rms,
            one.rms_difference,
            one.unit,
            percent(one.largest),
            percent(one.tolerance[0]),
            percent(one.tolerance[1]),
        )?;
    }
    Ok(text)
}

/// One picture for each name in `plot`: measured points with their spread, simulated curves in
/// the colour of their run.
fn pictures(config: &Config, found: &[Comparison], folder: &Path) -> Result<()> {
    let mut names: Vec<&String> = config.row.iter().map(|row| &row.plot).collect();
    names.dedup();
    for name in names {
        let rows: Vec<&Row> = config.row.iter().filter(|row| row.plot == *name).collect();
        let (mut runs, mut series) = (Vec::new(), Vec::<Series>::new());
        let mut add = |label: Option<&str>, points: Vec<(f64, f64)>, style, turn| {
            let is_known = series.iter().any(|one| one.label.as_deref() == label);
            let label = label.filter(|_| !is_known).map(str::to_owned);
            series.push(Series { label, points, style, turn });
        };
        for row in &rows {
            for (i, one) in found.iter().filter(|one| one.row == row.name).enumerate() {
                let measured = || one.measured.iter();
                if i == 0 {
                    let bars =
                        measured().flat_map(|p| [p.y - p.spread, p.y + p.spread].map(|y| (p.x, y)));
                    let points = measured().map(|p| (p.x, p.y)).collect();
                    add(Some("measured"), points, Style::Circles(4), 0);
                    add(None, bars.collect(), Style::Bars, 0);
                }
                for (run, values) in curves(one) {
                    let known = runs.iter().position(|known| *known == run);
                    let turn = known.unwrap_or(runs.len());
                    if known.is_none() {
                        runs.push(run);
                    }
                    let points = measured().zip(values).filter_map(|(p, s)| s.map(|s| (p.x, s)));
                    add(Some(run), points.collect(), Style::Dotted(2), turn);
                }
            }
        }
        let axes = Axes { x: rows[0].x.clone(), y: rows[0].y.join(", "), ..Axes::default() };
        draw(&folder.join(format!("{name}.svg")), &axes, &series)?;
    }
    Ok(())
}

/// The simulated ordinates of a comparison by the names of runs: of a band those of its ends.
fn curves(one: &Comparison) -> Vec<(&str, &[Option<f64>])> {
    match &one.ends[..] {
        [] => vec![(&one.run, &one.simulated)],
        ends => ends.iter().map(|end| (&end.run[..], &end.simulated[..])).collect(),
    }
}
