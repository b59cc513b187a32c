//! `solver map`: equilibria on a grid of numbers as a table, for a controller or another simulator.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Result;
use program::Unusable;
use reports::Status;
use serde_json::json;

use super::SceneArguments;
use crate::study::map::{Grid, Map, Row};
use run::report::table;

/// Tabulate equilibria of a scene without [time], probes and their derivatives on a grid of numbers
///
/// Writes a row for each combination of values, the last number fastest: the numbers, status, the probes, the pose of
/// the tip (mean position and rotation vector), the derivative of each by each number, and the stiffness at the tip, the
/// upper triangle of a matrix 6 × 6. SI units; NaN where there is no equilibrium, or one that must not be used. Rows that
/// are found are written every few seconds.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    of: SceneArguments,
    /// Values of a number: PATH=FROM:STEP:TO or PATH=VALUE,VALUE,... Can be given several times
    #[arg(long, value_name = "PATH=VALUES", required = true)]
    grid: Vec<Grid>,
    /// The table (CSV)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Tag whose pose and stiffness are tabulated
    #[arg(long, value_name = "TAG")]
    tip: Option<String>,
    /// A further number to differentiate by. Can be given several times
    #[arg(long, value_name = "PATH")]
    by: Vec<String>,
}

/// Least time between two times at which the rows are written.
const BETWEEN_WRITES: Duration = Duration::from_secs(2);

pub fn run(arguments: &Arguments) -> Result<()> {
    let (scene, grid) = (arguments.of.read()?, &arguments.grid);
    let map = Map::new(&scene, grid, &arguments.by, arguments.tip.as_deref())?;
    let (mut rows, count) = (vec![map.columns()], map.rows());
    let (mut u, mut found) = (Vec::new(), 0);
    let (start, mut written) = (Instant::now(), Instant::now());
    for i in 0..count {
        let row = map.row(i, &u)?;
        log::info!("{}", in_words(&row, grid, [i + 1, count], start));
        rows.push(text(&row, rows[0].len()));
        found += usize::from(row.status == Status::Ok);
        u = row.u;
        if written.elapsed() >= BETWEEN_WRITES {
            table::write(&arguments.output, rows.iter().cloned())?;
            written = Instant::now();
        }
    }
    let name = arguments.output.display();
    table::write(&arguments.output, rows)?;
    log::info!("{name}: {found} of {count} rows have an equilibrium that may be used");
    if found == 0 {
        let scene = arguments.of.scene.display();
        let why = format!("{scene}: no row has an equilibrium that may be used");
        return Err(Unusable(why).into());
    }
    Ok(())
}

fn text(row: &Row, columns: usize) -> Vec<String> {
    let numbers = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>();
    let mut text = numbers(&row.at);
    text.push(word(row.status));
    text.extend(row.values.as_deref().map(numbers).unwrap_or_default());
    text.resize(columns, f64::NAN.to_string());
    text
}

/// The status as reports have it.
fn word(status: Status) -> String {
    json!(status).as_str().unwrap_or_default().to_owned()
}

fn in_words(row: &Row, grid: &[Grid], [i, count]: [usize; 2], start: Instant) -> String {
    let numbers = grid.iter().zip(&row.at).map(|(own, value)| format!("{} = {value}", own.path));
    let status = match row.status {
        Status::Ok => String::new(),
        other => format!("  {}", word(other)),
    };
    let seconds = start.elapsed().as_secs_f64();
    format!("row {i}/{count}  {}{status}  {seconds:.1} s", numbers.collect::<Vec<_>>().join("  "))
}
