//! `solver optimize`: a design problem to a better body.

mod starts;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, ensure};
use design::{Cascade, Problem, folder};
use program::{Changes, FolderLock};
use scene::log_share;

/// Optimise shapes of chambers and pressures over time
///
/// Writes to the output folder: design.msh (tagged; design.NAME.msh for each of
/// several bodies), pressures.toml and parameters.toml (designed loads, as tables of a scene),
/// history.jsonl (one line per accepted iteration), report.json, and result.vtu (the
/// design at the end). Killed at any moment, the same command continues where it was.
#[derive(clap::Args)]
pub struct Arguments {
    /// The design problem
    design: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Begin anew, whatever the folder holds
    #[arg(long)]
    restart: bool,
    /// Design from so many starts side by side, the shape as modelled and others that handles and loads are moved to at random;
    /// the best is kept, and starts.csv has a line for each
    #[arg(long, value_name = "COUNT", default_value_t = 1)]
    starts: usize,
    /// The number of the start, of which 1 is the shape as modelled
    #[arg(long, hide = true, default_value_t = 1, conflicts_with = "starts")]
    start: usize,
    #[command(flatten)]
    changes: Changes,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let since = Instant::now();
    let problem = Problem::read(&arguments.design, &[], &arguments.changes)?;
    log_share(&problem.scene.body);
    let cascade = Cascade::new(&problem, &arguments.output, arguments.start)?;
    let _lock = FolderLock::new(&cascade.folder)?;
    ensure!(arguments.starts > 0, "--starts 0: expected 1 or more");
    let best = (arguments.starts > 1).then(|| {
        problem.file.checked(|_| starts::check(&problem.design))?;
        starts::best(arguments)
    });
    let best = best.transpose()?;
    if !folder::prepare(&cascade.folder, &cascade.inputs, arguments.restart)? {
        return Ok(());
    }
    if let Some(best) = best {
        folder::take_over(&best, &cascade.folder)?;
    }
    cascade.design(since)
}
