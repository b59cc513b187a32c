//! SIGINT and SIGTERM end a program in order.
//!
//! Results appear as a whole and states are written after every step, so that nothing has to be
//! saved: programs that were started are ended, what is unfinished is removed.

#[cfg(unix)]
use nix::sys::signal::Signal;

#[cfg(unix)]
use crate::signals::signals;
use crate::terminal::to_stderr;

/// From now on the process ends in order when it is interrupted, with the exit code that shells
/// give to a process that the signal has ended: 130 or 143. To be called before the first thread is
/// started.
///
/// The signals are blocked in all threads but one, which waits for them. A handler would not do: METIS
/// puts its own in place while it orders, which takes SIGTERM for an error of METIS.
#[cfg(unix)]
pub fn end_in_order(name: &str) {
    let signals = signals();
    // Without it the signals end the process as ever, only in less order.
    if signals.thread_block().is_err() {
        return;
    }
    let name = name.to_owned();
    let wait = move || {
        if let Ok(signal) = signals.wait() {
            end(&name, signal);
        }
    };
    if std::thread::Builder::new().name("signals".into()).spawn(wait).is_err() {
        let _as_ever = signals.thread_unblock();
    }
}

/// Elsewhere signals end the process as ever.
#[cfg(not(unix))]
pub fn end_in_order(_name: &str) {}

#[cfg(unix)]
#[allow(clippy::exit, reason = "the other threads do not know of the signal")]
fn end(name: &str, signal: Signal) {
    let _no_new_children = crate::child::kill_all();
    let _no_new_files = mesh::io::remove_unfinished();
    let next = match name {
        "solver" => "the same command continues where it was",
        _ => "nothing unfinished is left; the same command does it again",
    };
    to_stderr(&format!("{name}: interrupted by {signal}; {next}"));
    std::process::exit(128 + signal as i32);
}
