//! `solver map`: equilibria on a grid of numbers as a table, for a controller or another simulator.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use program::{Unusable, read_checkpoint, write_checkpoint};
use reports::Status;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{SceneArguments, hash_inputs};
use crate::study::map::{Grid, Map, Row};
use run::report::table;

/// Tabulate equilibria of a scene without [time], probes and their derivatives on a grid of numbers
///
/// Writes a row for each combination of values, the last number fastest: the numbers, status, the probes, the pose of
/// the tip (mean position and rotation vector), the derivative of each by each number, and the stiffness at the tip, the
/// upper triangle of a matrix 6 × 6. SI units; NaN where there is no equilibrium, or one that must not be used. A table that
/// was interrupted continues after its last row when the same command is given again.
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
    /// Forget an interrupted table
    #[arg(long)]
    restart: bool,
}

/// A table that is not complete.
#[derive(Default, Serialize, Deserialize)]
struct Begun {
    /// What the rows depend on.
    inputs: String,
    /// The rows, as text.
    rows: Vec<Vec<String>>,
    /// Displacement of the last row [m].
    u: Vec<f64>,
}

/// Least time between two checkpoints.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(2);
/// Word of a row that was found.
const FOUND: &str = "ok";

pub fn run(arguments: &Arguments) -> Result<()> {
    let (scene, grid) = (arguments.of.read()?, &arguments.grid);
    let map = Map::new(&scene, grid, &arguments.by, arguments.tip.as_deref())?;
    let (columns, count) = (map.columns(), map.rows());
    let inputs = format!("{} {grid:?} {}", hash_inputs(&scene)?, columns.join(","));
    let path = checkpoint(&arguments.output)?;
    let mut begun = begin(&path, inputs, arguments.restart)?;
    let (start, mut saved) = (Instant::now(), Instant::now());
    for i in begun.rows.len()..count {
        let row = map.row(i, &begun.u)?;
        log::info!("{}", in_words(&row, grid, [i + 1, count], start));
        begun.rows.push(text(&row, columns.len()));
        begun.u = row.u;
        if i + 1 < count && saved.elapsed() >= BETWEEN_CHECKPOINTS {
            write_checkpoint(&path, scene::PROGRAM, &begun)?;
            saved = Instant::now();
        }
    }
    let table = [columns].into_iter().chain(begun.rows.iter().cloned());
    table::write(&arguments.output, table)?;
    mesh::io::remove_output(&path)?;
    let found = begun.rows.iter().filter(|row| row[grid.len()] == FOUND).count();
    log::info!(
        "{}: {found} of {count} rows have an equilibrium that may be used",
        arguments.output.display()
    );
    if found == 0 {
        return Err(Unusable(format!(
            "{}: no row has an equilibrium that may be used",
            arguments.of.scene.display()
        ))
        .into());
    }
    Ok(())
}

/// The file beside a table from which it continues.
fn checkpoint(table: &Path) -> Result<PathBuf> {
    let name =
        table.file_name().with_context(|| format!("{}: no name of a file", table.display()))?;
    Ok(table.with_file_name(format!(".{}.checkpoint.json", name.to_string_lossy())))
}

/// The rows of an interrupted table with the same inputs, if there are any.
fn begin(path: &Path, inputs: String, restart: bool) -> Result<Begun> {
    if !restart && path.exists() {
        let begun: Begun = read_checkpoint(path, scene::PROGRAM)?;
        if begun.inputs == inputs {
            log::info!("continuing after row {}", begun.rows.len());
            return Ok(begun);
        }
        log::warn!(
            "{}: it belongs to another table, so that all rows are computed again",
            path.display()
        );
    }
    Ok(Begun { inputs, ..Begun::default() })
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
    json!(status).as_str().unwrap_or(FOUND).to_owned()
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
