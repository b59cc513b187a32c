//! `solver`: simulate, optimise and check soft pneumatic bodies.

mod cmd;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use program::Verbosity;

/// Keeps freed memory at hand: fronts and element blocks come and go by the
/// megabyte, and pages from the system cost a quarter of an assembly.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Finite elements of pressurised silicone, and designs by their gradient
#[derive(Parser)]
#[command(version)]
struct Program {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    verbosity: Verbosity,
    /// Threads to use; all cores if not given
    #[arg(long, global = true)]
    threads: Option<usize>,
}

#[derive(Subcommand)]
enum Verb {
    Simulate(cmd::simulate::Arguments),
    Optimize(cmd::optimize::Arguments),
    Check(cmd::check::Arguments),
    Gradient(cmd::gradient::Arguments),
    List(cmd::list::Arguments),
    Fit(cmd::fit::Arguments),
    Compare(cmd::compare::Arguments),
    Plot(cmd::plot::Arguments),
    Import(cmd::import::Arguments),
}

fn main() -> ExitCode {
    let program = Program::parse();
    program::run("solver", program.verbosity, || {
        if let Some(threads) = program.threads {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
        }
        match &program.verb {
            Verb::Simulate(arguments) => cmd::simulate::run(arguments),
            Verb::Optimize(arguments) => cmd::optimize::run(arguments),
            Verb::Check(arguments) => cmd::check::run(arguments),
            Verb::Gradient(arguments) => cmd::gradient::run(arguments),
            Verb::List(arguments) => cmd::list::run(arguments),
            Verb::Fit(arguments) => cmd::fit::run(arguments),
            Verb::Compare(arguments) => cmd::compare::run(arguments),
            Verb::Plot(arguments) => cmd::plot::run(arguments),
            Verb::Import(arguments) => cmd::import::run(arguments),
        }
    })
}
