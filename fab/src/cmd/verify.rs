//! `fab verify`: reads a mold back from its files and proves it right.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;
use mesh::io::note_results;
use program::Unusable;

use crate::verify::{Against, Status, verify};

/// Arguments of `fab verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder with mold.json and its parts
    pub folder: PathBuf,
    /// The design, if it is no longer where mold.json says
    #[arg(long)]
    pub design: Option<PathBuf>,
    /// The surface that the design was meshed from, if it is no longer where mold.json says
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// The mesh as modelled, if it is no longer where mold.json says
    #[arg(long, value_name = "MODELLED")]
    pub from: Option<PathBuf>,
    /// Folder that `solver simulate` wrote for the design: checks its walls under load
    #[arg(long)]
    pub simulation: Option<PathBuf>,
}

/// Prints one line per check on standard output.
///
/// # Errors
/// If the folder has no readable report; [`Unusable`] if a check fails.
pub fn run(args: &Args) -> Result<()> {
    let design = args.design.as_deref();
    let [model, from, simulation] =
        [&args.model, &args.from, &args.simulation].map(|path| path.as_deref());
    for results in [Some(args.folder.as_path()), simulation].into_iter().flatten() {
        note_results(results);
    }
    let lines = verify(&args.folder, Against { design, model, from, simulation })?;
    let mut out = program::stdout();
    for line in &lines {
        writeln!(out, "{line}")?;
    }
    let failed = lines.iter().filter(|line| line.status == Status::Fail).count();
    if failed > 0 {
        let folder = args.folder.display();
        let message = format!("{folder}: {failed} of {} checks failed", lines.len());
        return Err(Unusable(message).into());
    }
    Ok(())
}
