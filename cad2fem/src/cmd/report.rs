//! `cad2fem report`: all results in a folder → one page of HTML.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context as _, Result};

/// Simulations, optimisations and molds of a folder and of the folders in it, in one file that
/// opens without a server or a network
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of results, such as build/frog, or of one simulation, optimisation or mold
    folder: PathBuf,
    /// Page to write (.html)
    #[arg(short, long)]
    output: PathBuf,
    /// Title of the page [default: the name of the folder]
    #[arg(long)]
    title: Option<String>,
    /// Only the last state of each simulation and the last shape of each optimisation: a page that is small enough for
    /// mail
    #[arg(long)]
    final_only: bool,
}

/// Runs the verb.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let place = || args.folder.display().to_string();
    let full = system::canonical(&args.folder).with_context(place)?;
    let name = full.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let shown = if args.final_only { page::Shown::Last } else { page::Shown::All };
    let title = args.title.as_ref().unwrap_or(&name);
    let page::Summary { parts: [runs, designs, molds], bytes } =
        page::write(&args.folder, &args.output, title, shown)?;
    log::info!(
        "{}: {runs} simulations, {designs} optimisations, {molds} molds; {:.1} MB, {:.1} s",
        args.output.display(),
        bytes as f64 * 1e-6,
        start.elapsed().as_secs_f64()
    );
    Ok(())
}
