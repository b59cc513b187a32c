//! Programs that ours runs.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

use std::process::Command;

use nix::sys::signal::{SigSet, Signal};
use program::Process;

#[test]
fn a_signal_that_ours_blocks_reaches_it() {
    SigSet::from(Signal::SIGTERM).thread_block().unwrap();
    let mut looks = Command::new("grep");
    looks.args(["--quiet", "SigBlk:.*0000$", "/proc/self/status"]);
    assert!(Process::spawn(&mut looks).unwrap().wait().unwrap().success());
}
