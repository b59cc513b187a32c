//! `solver`: simulate, optimise and check soft pneumatic bodies.

use std::process::ExitCode;

use anyhow::Context as _;
use clap::Parser;
use program::Verbosity;
use solver::cmd::Verb;

/// Keeps freed memory for reuse: fronts and element blocks come and go by the
/// megabyte, and pages from the system cost a quarter of an assembly.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Finite elements of pressurised silicone, and designs by their gradient
#[derive(Parser)]
#[command(name = "solver", version)]
struct Program {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    verbosity: Verbosity,
    /// Threads to use; all cores if not given
    #[arg(long, global = true, value_parser = clap::value_parser!(u16).range(..=MOST_THREADS))]
    threads: Option<u16>,
}

/// Each takes two megabytes for its stack, and the system has an end of threads.
const MOST_THREADS: i64 = 1024;

/// How long the allocator keeps free memory before it gives it back to the system [ms]:
/// longer than vectors are away between two uses, as the system clears every page that it
/// hands out. A static solve of the gripper had 53 000 page faults with the allocator's own
/// second, and 16 000 with this.
const KEEP_FREE_MEMORY: std::ffi::c_long = 5000;
/// `mi_option_purge_delay` in mimalloc.h, which the bindings do not name.
const PURGE_DELAY: libmimalloc_sys::mi_option_t = 15;

fn main() -> ExitCode {
    // SAFETY: sets a number; to be done before threads start, and without effect where
    // MIMALLOC_PURGE_DELAY is set
    #[allow(unsafe_code)]
    unsafe {
        libmimalloc_sys::mi_option_set_default(PURGE_DELAY, KEEP_FREE_MEMORY);
    }
    let program: Program = match program::parse() {
        Ok(program) => program,
        Err(code) => return code,
    };
    program::run("solver", program.verbosity, || {
        let threads = program.threads.map_or(0, usize::from); // 0 for all cores
        // this thread is one of them: it need not wake another one for each piece of work
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread();
        pool.build_global().context("threads cannot be started")?;
        program.verb.run()
    })
}
