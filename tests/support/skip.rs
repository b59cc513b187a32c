//! Tests that cannot run on this machine: they are counted as skipped, not as passed.
//!
//! `fab` and `cad2fem`, which cannot use this crate, include this file, so that it uses
//! nothing but the standard library.

use std::fs::OpenOptions;
use std::io::Write as _;

/// The variable that names the list of skipped tests. `.ci/test` sets it and counts the list.
const LIST: &str = "PUFFER_SKIPPED";

/// Prints that the running test is skipped, and why, and appends a line `program, test,
/// reason` (separated by tabs) to the list of skipped tests. The caller returns then.
pub fn skip(reason: &str) {
    eprintln!("SKIPPED: {reason}");
    let Some(list) = std::env::var_os(LIST) else { return };
    let program = std::env::current_exe().expect("a test is a file");
    // the test harness names the thread of a test after it
    let thread = std::thread::current();
    let line = format!("{}\t{}\t{reason}\n", program.display(), thread.name().unwrap_or("?"));
    let mut list = OpenOptions::new().create(true).append(true).open(list).expect("a list");
    list.write_all(line.as_bytes()).expect("the list is writable");
}
