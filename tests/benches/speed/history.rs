//! Times of whole runs from one full benchmark to the next, as a picture.

use std::path::Path;

use anyhow::Result;
use solver::plot::{Axes, Series, Style, draw};

use crate::row::find;
use crate::stored::Stored;

/// Rows that are drawn.
const DRAWN: [&str; 2] = ["static solve", "motion"];

/// Draws the times of the runs on one machine, relative to the first; none for fewer than
/// two.
pub fn picture(runs: &[Stored], machine: &str, path: &Path) -> Result<Option<String>> {
    let runs: Vec<&Stored> = runs.iter().filter(|run| run.machine == machine).collect();
    let Some(first) = runs.first().filter(|_| runs.len() > 1) else { return Ok(None) };
    let rows = first.rows.iter().filter(|row| DRAWN.contains(&row.what.as_str()));
    let series = rows.enumerate().map(|(turn, row)| {
        let of = |run: &Stored| Some(find(&run.rows, &row.what, &row.body)?.seconds.median);
        let points = runs.iter().enumerate().filter_map(|(i, run)| {
            of(run).map(|seconds| ((i + 1) as f64, seconds / row.seconds.median))
        });
        Series { label: Some(row.key()), points: points.collect(), style: Style::Dotted(2), turn }
    });
    let axes = Axes {
        x: format!("full run, the last of commit {}", runs[runs.len() - 1].commit),
        y: "time / time of the first run".to_owned(),
        ..Axes::default()
    };
    draw(path, &axes, &series.collect::<Vec<_>>())?;
    Ok(Some(format!("{} runs on this machine: {}\n", runs.len(), path.display())))
}
