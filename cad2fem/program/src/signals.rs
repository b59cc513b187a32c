//! The signals that interrupt a program.

use std::process::Command;

#[cfg(unix)]
use nix::sys::signal::{SigSet, Signal};

/// Those that end a program in order.
#[cfg(unix)]
pub(crate) fn signals() -> SigSet {
    [Signal::SIGINT, Signal::SIGTERM].into_iter().collect()
}

/// A program that ours runs would block what ours blocks.
#[cfg(unix)]
#[allow(unsafe_code, reason = "between fork and exec one system call, which is allowed there")]
pub(crate) fn unblock_in(command: &mut Command) {
    use std::os::unix::process::CommandExt;
    let signals = signals();
    unsafe { command.pre_exec(move || Ok(signals.thread_unblock()?)) };
}

/// Elsewhere nothing is blocked.
#[cfg(not(unix))]
pub(crate) fn unblock_in(_command: &mut Command) {}
