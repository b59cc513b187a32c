//! `solver`: simulate, optimise and check soft pneumatic bodies.

use std::process::ExitCode;

use clap::Parser;
use program::Verbosity;
use solver::cmd::Verb;

/// Keeps freed memory for reuse: fronts and element blocks come and go by the
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

fn main() -> ExitCode {
    let program = Program::parse();
    program::run("solver", program.verbosity, || {
        if let Some(threads) = program.threads {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
        }
        program.verb.run()
    })
}
