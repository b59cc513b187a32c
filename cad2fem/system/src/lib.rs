//! What differs between operating systems: how a program is interrupted and ends,
//! how much memory there is, and how paths are written.
//!
//! `unix` is for Linux and macOS, `windows` for Windows; both have the same functions. Other crates ask no system for
//! its name.

#[cfg(unix)]
mod memory;
mod paths;
#[cfg_attr(unix, path = "unix.rs")]
#[cfg_attr(windows, path = "windows.rs")]
mod this;

pub use paths::{canonical, portable};
pub use this::{available_memory, on_interruption, peak_memory, permissions, unblock_in};

/// What asked a program to end.
#[derive(Clone, Debug)]
pub struct Interruption {
    /// SIGINT, for example.
    pub name: String,
    /// Exit code that shells give to a process that it ended.
    pub code: i32,
}
