//! The program `cad2fem`.

use std::process::ExitCode;

use cad2fem::cmd::Verb;
use clap::Parser;
use program::Verbosity;

/// CAD surfaces and implicit models → surfaces in named regions → tetrahedra.
///
/// Every file it writes is in metres. Exit codes: 0 the result is usable, 1 it must
/// not be used, 2 usage or input error.
#[derive(Debug, Parser)]
#[command(name = "cad2fem", version)]
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
    program::run("cad2fem", cli.verbosity, || cli.verb.run())
}
