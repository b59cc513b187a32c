//! Linux and macOS.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

use nix::sys::signal::{SigSet, Signal};

use crate::Interruption;

/// Permissions of a new file, of which the mask of the user is still taken away; nothing where files have none.
pub fn permissions(mode: u32) -> Option<Permissions> {
    Some(Permissions::from_mode(mode))
}

/// From now on `act` is called when the process is asked to end, in a thread of its own. To be called before the first
/// thread is started. If the system refuses, the process ends as ever, only in less order.
///
/// The signals are blocked in all threads but one, which waits for them. A handler would not do: METIS puts its own in
/// place while it orders, which takes SIGTERM for an error of METIS.
pub fn on_interruption(act: impl FnOnce(Interruption) + Send + 'static) {
    let signals = signals();
    if signals.thread_block().is_err() {
        return;
    }
    let wait = move || {
        if let Ok(signal) = signals.wait() {
            act(Interruption { name: signal.to_string(), code: 128 + signal as i32 });
        }
    };
    if std::thread::Builder::new().name("signals".into()).spawn(wait).is_err() {
        let _as_ever = signals.thread_unblock();
    }
}

/// A program that ours runs would block the signals that ours blocks: this one does not.
#[allow(unsafe_code, reason = "between fork and exec one system call, which is allowed there")]
pub fn unblock_in(command: &mut Command) {
    let signals = signals();
    // SAFETY: sigprocmask may be called between fork and exec
    unsafe { command.pre_exec(move || Ok(signals.thread_unblock()?)) };
}

/// Those that end a program in order.
fn signals() -> SigSet {
    [Signal::SIGINT, Signal::SIGTERM].into_iter().collect()
}

/// Largest resident set of this process so far [B].
#[cfg(target_os = "linux")]
pub fn peak_memory() -> Option<usize> {
    // getrusage would count what the shell held before it became this program
    crate::memory::kibibytes("/proc/self/status".as_ref(), "VmHWM:")
}

/// Largest resident set of this process so far [B].
#[cfg(not(target_os = "linux"))]
pub fn peak_memory() -> Option<usize> {
    use nix::sys::resource::{UsageWho, getrusage};
    // bytes on macOS
    usize::try_from(getrusage(UsageWho::RUSAGE_SELF).ok()?.max_rss()).ok()
}

/// Memory that this process may still take [B]; macOS does not say.
pub fn available_memory() -> Option<usize> {
    crate::memory::available_in("/".as_ref())
}
