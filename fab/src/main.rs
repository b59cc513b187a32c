//! The program `fab`.

use std::process::ExitCode;

use anyhow::Context as _;
use clap::Parser;
use fab::cmd::Verb;
use program::Verbosity;

/// Printable molds from an optimised body.
///
/// Reads metres, writes millimetres. Exit codes: 0 the mold can be printed, 1 it must
/// not be, 2 usage or input error.
#[derive(Debug, Parser)]
#[command(name = "fab", version)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    verbosity: Verbosity,
}

fn main() -> ExitCode {
    let cli: Cli = match program::parse() {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    program::run("fab", cli.verbosity, || {
        let pool = rayon::ThreadPoolBuilder::new();
        pool.build_global().context("threads cannot be started")?;
        cli.verb.run()
    })
}
