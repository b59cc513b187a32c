//! SIGINT and SIGTERM end a program in order.
//!
//! Results appear as a whole and states are written after every step, so that nothing has to be
//! saved: programs that were started are ended, what is unfinished is removed.

#[cfg(unix)]
use crate::cli::to_stderr;

/// From now on the process ends in order when it is interrupted, with the exit code that shells
/// give to a process that the signal has ended: 130 or 143.
#[cfg(unix)]
pub fn end_in_order(name: &str) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let name = name.to_owned();
    let wait = move |mut signals: signal_hook::iterator::Signals| {
        if let Some(signal) = signals.forever().next() {
            end(&name, signal);
        }
    };
    // Without it the signals end the process as ever, only in less order.
    if let Ok(signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) {
        let _ = std::thread::Builder::new().name("signals".into()).spawn(move || wait(signals));
    }
}

/// Elsewhere signals end the process as ever.
#[cfg(not(unix))]
pub fn end_in_order(_name: &str) {}

#[cfg(unix)]
#[allow(clippy::exit, reason = "the other threads do not know of the signal")]
fn end(name: &str, signal: i32) {
    let _no_new_children = crate::child::kill_all();
    let _no_new_files = mesh::io::remove_unfinished();
    let signal_name = signal_hook::low_level::signal_name(signal).unwrap_or("a signal");
    to_stderr(&format!("{name}: interrupted by {signal_name}; to continue: the same command"));
    std::process::exit(128 + signal);
}
