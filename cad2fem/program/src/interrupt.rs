//! A program that is interrupted ends in order.
//!
//! Results appear as a whole and states are written after every step, so that nothing has to be
//! saved: programs that were started are ended, what is unfinished is removed.

use system::Interruption;

use crate::terminal::to_stderr;

/// From now on the process ends in order when it is interrupted, with the exit code that shells
/// give to it: 130 or 143. To be called before the first thread is started.
pub fn end_in_order(name: &str) {
    let name = name.to_owned();
    system::on_interruption(move |by| end(&name, &by));
}

#[allow(clippy::exit, reason = "the other threads do not know of the interruption")]
fn end(name: &str, by: &Interruption) {
    let _no_new_children = crate::child::kill_all();
    let _no_new_files = mesh::io::remove_unfinished();
    let next = match name {
        "solver" => "the same command continues where it was",
        _ => "nothing unfinished is left; the same command does it again",
    };
    to_stderr(&format!("{name}: interrupted by {}; {next}", by.name));
    std::process::exit(by.code);
}
