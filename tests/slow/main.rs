//! Tests that take minutes: the molds of all scenes and templates, commands of the book, notebooks, the wheel, kept designs
//! simulated again, and simulations beside measurements.
//!
//! `make test-all` makes the beam and then runs these; they are not for
//! `make test`, which says so for each.
#![allow(missing_docs, clippy::unwrap_used)]

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, Once, PoisonError};

use tests::workdir::{self, repository};

mod book;
mod molds;
mod new;
mod notebooks;
mod results;
mod studio;
mod sweep;
mod validation;
mod wheel;
mod windows;

/// Runs `make` with a goal, and values for it after blanks, in this checkout, one at a time, and returns what it printed.
fn make(goal: &str) -> String {
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    run(workdir::make().args(goal.split_whitespace()).current_dir(repository()))
}

/// The folder of the results of `make beam`; made once for all tests here.
fn beam() -> PathBuf {
    static MADE: Once = Once::new();
    MADE.call_once(|| _ = make("beam"));
    repository().join("build/beam")
}

/// Runs a command to its good end and returns what it printed.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    assert!(output.status.success(), "{command:?}: {said}");
    said
}
