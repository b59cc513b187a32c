//! Log messages on standard error, and exit codes.
//!
//! Exit codes: 0 the result is usable; 1 the program ran but its result must not
//! be used ([`Unusable`]); 2 usage or input error; 130 and 143 interrupted by SIGINT, SIGTERM.

use std::io::ErrorKind;
use std::process::ExitCode;

use clap::{ArgAction, Args};
use log::{Level, LevelFilter, Log, Metadata, Record};
use mesh::io::IoError;

use crate::interrupt::end_in_order;
use crate::terminal::to_stderr;

/// How much a program reports on standard error; flatten it into the arguments.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct Verbosity {
    /// Report only warnings and errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Report more; twice for everything
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
}

impl Verbosity {
    fn level(self) -> LevelFilter {
        match (self.quiet, self.verbose) {
            (true, _) => LevelFilter::Warn,
            (false, 0) => LevelFilter::Info,
            (false, 1) => LevelFilter::Debug,
            (false, _) => LevelFilter::Trace,
        }
    }
}

/// The program ran, but what it made must not be used; the message says why.
/// Anywhere in an error chain it makes the exit code 1.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Unusable(pub String);

/// Runs `f` with log messages on stderr and turns its result into an exit code.
///
/// An error is printed as `name: outermost: ...: innermost cause`. A reader that
/// closed our standard output early, as `head` does, is no error.
pub fn run(name: &str, verbosity: Verbosity, f: impl FnOnce() -> anyhow::Result<()>) -> ExitCode {
    // Fails only if a logger is there already, which is then as good as ours.
    if log::set_logger(&StderrLogger).is_ok() {
        log::set_max_level(verbosity.level());
    }
    end_in_order(name);
    let Err(error) = f() else { return ExitCode::SUCCESS };
    if is_broken_pipe(&error) {
        return ExitCode::SUCCESS;
    }
    to_stderr(&format!("{name}: {}", message(&error)));
    ExitCode::from(exit_code(&error))
}

/// The chain of an error. What a message below begins with, as the name of a file that both state, is
/// said once.
fn message(error: &anyhow::Error) -> String {
    let said = |below: &str, context: &str| {
        let rest = below.strip_prefix(context);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(':'))
    };
    let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
    let joined = causes.into_iter().rev().reduce(|below, context| {
        if said(&below, &context) { below } else { format!("{context}: {below}") }
    });
    joined.unwrap_or_default()
}

fn exit_code(error: &anyhow::Error) -> u8 {
    // The chain does not show an `Unusable` that was attached as context; `is` does.
    let unusable = error.is::<Unusable>() || error.chain().any(|cause| cause.is::<Unusable>());
    if unusable { 1 } else { 2 }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let system = match cause.downcast_ref() {
            Some(IoError::System { cause, .. }) => Some(cause),
            _ => cause.downcast_ref::<std::io::Error>(),
        };
        system.is_some_and(|system| system.kind() == ErrorKind::BrokenPipe)
    })
}

/// Prints the message; warnings and errors are named as such.
struct StderrLogger;

impl Log for StderrLogger {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.level() <= log::max_level()
    }

    fn log(&self, record: &Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let kind = match record.level() {
            Level::Error => "error: ",
            Level::Warn => "warning: ",
            _ => "",
        };
        to_stderr(&format!("{kind}{}", record.args()));
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests {
    use anyhow::anyhow;

    use super::*;

    #[test]
    fn unusable_results_exit_with_1_wherever_they_are_in_the_chain() {
        let unusable = || Unusable("3 inverted tetrahedra".into());
        assert_eq!(exit_code(&anyhow!("no such file")), 2);
        assert_eq!(exit_code(&unusable().into()), 1);
        let wrapped = anyhow::Error::from(unusable()).context("volume.msh").context("tetmesh");
        assert_eq!(exit_code(&wrapped), 1);
        let attached = anyhow!("cause").context(unusable()).context("outer");
        assert_eq!(exit_code(&attached), 1);
    }

    #[test]
    fn a_file_is_named_once() {
        let content = IoError::content("bad.toml".as_ref(), "line 3");
        let twice = anyhow::Error::from(content).context("bad.toml").context("design.toml");
        assert_eq!(message(&twice), "design.toml: bad.toml: line 3");
        let other = anyhow!("bad.tomlet: line 3").context("bad.toml");
        assert_eq!(message(&other), "bad.toml: bad.tomlet: line 3");
        assert_eq!(message(&anyhow!("alone")), "alone");
    }

    #[test]
    fn only_a_closed_reader_is_forgiven() {
        let broken = || std::io::Error::from(ErrorKind::BrokenPipe);
        let direct = anyhow::Error::from(broken()).context("table");
        assert!(is_broken_pipe(&direct));
        let file = IoError::System { path: "/dev/stdout".into(), action: "write", cause: broken() };
        assert!(is_broken_pipe(&file.into()));
        let full = std::io::Error::from(ErrorKind::StorageFull);
        assert!(!is_broken_pipe(&full.into()));
    }
}
