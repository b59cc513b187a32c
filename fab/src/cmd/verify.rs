//! `fab verify`: reads a mold back from its files and proves it right.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;
use mesh::io::write_atomic;
use program::Unusable;

use crate::verify::{Against, Status, verify};

/// Arguments of `fab verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder with mold.json and its parts
    pub folder: PathBuf,
    /// What it is compared with
    #[command(flatten)]
    pub against: Against,
    /// List the checks that hold, too, in place of counting them
    #[arg(long)]
    pub all: bool,
    /// File for the lines of all checks
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Prints a line per check that fails or warns on standard output, with `--all` of those that hold, too, and
/// the counts last.
pub fn run(args: &Args) -> Result<()> {
    let mut lines = verify(&args.folder, &args.against)?;
    // What a person has to look at comes first.
    lines.sort_by_key(|line| std::cmp::Reverse(line.status));
    let [held, warned, failed] = [Status::Ok, Status::Warn, Status::Fail]
        .map(|status| lines.iter().filter(|line| line.status == status).count());
    if let Some(path) = &args.output {
        write_atomic(path, |out| lines.iter().try_for_each(|line| writeln!(out, "{line}")))?;
    }
    let mut out = program::stdout();
    for line in lines.iter().filter(|line| args.all || line.status != Status::Ok) {
        writeln!(out, "{line}")?;
    }
    let more = if args.all { "" } else { "; --all lists those that hold" };
    writeln!(out, "{held} checks hold, {warned} warn, {failed} fail{more}")?;
    if failed > 0 {
        let folder = args.folder.display();
        let message = format!("{folder}: {failed} of {} checks failed", lines.len());
        return Err(Unusable(message).into());
    }
    Ok(())
}
