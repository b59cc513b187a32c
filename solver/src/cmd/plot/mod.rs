//! `solver plot`: numbers of runs as curves.

mod points;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use points::Points;

use crate::plot::{Axes, Series, Style, draw};
use run::report::columns::{at_rest, number, rows};

/// Draw numbers of one or more runs against each other, as SVG or PNG
///
/// A run is a history.jsonl of optimize or steps.jsonl of simulate, a row per line, a report.json of
/// simulate, a row per load step, or a file of compare, a row per run. A column is a key, or keys joined by dots:
/// `objective`, `terms.throat`, `reactions.top.2`. A factor may follow a star, a number or an expression
/// as in `mean_displacement.throat*1e3` and `angle*180/pi`; `terms.throat + terms.smooth` is a sum. Without --x, rows
/// are counted. Rows without the number are left out. With --x a simulation begins at rest, but not on a logarithmic axis.
#[derive(clap::Args)]
pub struct Arguments {
    /// Runs: one curve each, for every --y
    #[arg(required = true)]
    runs: Vec<PathBuf>,
    /// File to write, .svg or .png
    #[arg(short, long)]
    output: PathBuf,
    /// CSV file with a header whose points are laid over; again for each. x and y are its first two columns; or FILE:X,Y
    /// names them, with factors and sums as of the columns of runs
    #[arg(long = "points", value_name = "FILE[:X,Y]")]
    points: Vec<Points>,
    /// Column of the abscissa
    #[arg(long)]
    x: Option<String>,
    /// Columns of the ordinate
    #[arg(long, required = true, value_delimiter = ',')]
    y: Vec<String>,
    /// Names of the curves, in their order
    #[arg(long, value_delimiter = ',')]
    labels: Vec<String>,
    /// Written at the abscissa
    #[arg(long)]
    x_title: Option<String>,
    /// Written at the ordinate
    #[arg(long)]
    y_title: Option<String>,
    /// Logarithmic ordinate
    #[arg(long)]
    log: bool,
    /// Logarithmic abscissa
    #[arg(long)]
    log_x: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let curves = arguments.runs.len() * arguments.y.len() + arguments.points.len();
    ensure!(
        arguments.labels.is_empty() || arguments.labels.len() == curves,
        "--labels names {} curves, there are {curves}, points of --points among them",
        arguments.labels.len()
    );
    let mut series: Vec<Series> = Vec::new();
    for path in &arguments.runs {
        let rest =
            (arguments.x.is_some() && !arguments.log_x && !arguments.log).then(|| at_rest(path));
        let rows: Vec<Value> = rest.flatten().into_iter().chain(rows(path)?).collect();
        for y in &arguments.y {
            let turn = series.len();
            let label =
                arguments.labels.get(turn).cloned().unwrap_or_else(|| match arguments.runs.len() {
                    1 => y.clone(),
                    _ => format!("{}: {y}", path.display()),
                });
            let points = points(&rows, arguments.x.as_deref(), y)
                .with_context(|| path.display().to_string())?;
            series.push(Series { label: Some(label), points, style: Style::Dotted(2), turn });
        }
    }
    for points in &arguments.points {
        let turn = series.len();
        let label = arguments.labels.get(turn).cloned().unwrap_or_else(|| points.name());
        let points = points.read()?;
        series.push(Series { label: Some(label), points, style: Style::Rings(5), turn });
    }
    let title =
        |title: &Option<String>, column: &str| title.clone().unwrap_or_else(|| column.to_owned());
    let axes = Axes {
        x: title(&arguments.x_title, arguments.x.as_deref().unwrap_or("row")),
        y: title(&arguments.y_title, &arguments.y.join(", ")),
        log_x: arguments.log_x,
        log_y: arguments.log,
    };
    draw(&arguments.output, &axes, &series)
}

/// The rows that have both numbers: before surfaces meet there is no gap, for one.
fn points(rows: &[Value], x: Option<&str>, y: &str) -> Result<Vec<(f64, f64)>> {
    let point = |(i, row): (usize, &Value)| {
        let x = x.map_or(Ok(i as f64), |x| number(row, x))?;
        Ok((x, number(row, y)?))
    };
    let (points, missing): (Vec<_>, Vec<_>) =
        rows.iter().enumerate().map(point).partition(Result::is_ok);
    match missing.into_iter().next() {
        Some(error) if points.is_empty() => error.map(|_: (f64, f64)| Vec::new()),
        _ => points.into_iter().collect(),
    }
}
