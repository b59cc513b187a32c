//! `tagger`: boundary facets of a tetrahedral mesh → named tags.

use std::process::ExitCode;

use clap::Parser;
use program::Verbosity;
use tagger::cmd::Verb;

/// Gives names to parts of the boundary of a tetrahedral mesh.
#[derive(Parser)]
#[command(name = "tagger", version, arg_required_else_help = true)]
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
    program::run("tagger", cli.verbosity, || cli.verb.run())
}
