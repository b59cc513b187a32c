//! Windows.

#![allow(unsafe_code, reason = "functions of the system")]

use std::fs::Permissions;
use std::mem::size_of;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use windows_sys::Win32::System::Console::{
    CTRL_BREAK_EVENT, CTRL_C_EVENT, CTRL_CLOSE_EVENT, SetConsoleCtrlHandler,
};
use windows_sys::Win32::System::ProcessStatus::{GetProcessMemoryInfo, PROCESS_MEMORY_COUNTERS};
use windows_sys::Win32::System::SystemInformation::{GlobalMemoryStatusEx, MEMORYSTATUSEX};
use windows_sys::Win32::System::Threading::GetCurrentProcess;

use crate::Interruption;

/// Permissions of a new file: those of its folder.
pub fn permissions(_mode: u32) -> Option<Permissions> {
    None
}

type Act = Box<dyn FnOnce(Interruption) + Send>;

static ACT: Mutex<Option<Act>> = Mutex::new(None);

/// From now on `act` is called when the process is asked to end, by Ctrl-C or by the end of its console, in a thread
/// of its own. If the system refuses, the process ends as ever, only in less order.
pub fn on_interruption(act: impl FnOnce(Interruption) + Send + 'static) {
    *ACT.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(act));
    // SAFETY: the handler is a function that stays
    unsafe { SetConsoleCtrlHandler(Some(handle), 1) };
}

unsafe extern "system" fn handle(event: u32) -> i32 {
    let (name, code) = match event {
        CTRL_C_EVENT => ("Ctrl-C", 130),
        CTRL_BREAK_EVENT => ("Ctrl-Break", 130),
        CTRL_CLOSE_EVENT => ("the end of its console", 143),
        _ => return 0,
    };
    let act = ACT.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(act) = act {
        act(Interruption { name: name.to_owned(), code });
    }
    1
}

/// A program that ours runs is interrupted as ours is: nothing has to be done.
pub fn unblock_in(_command: &mut Command) {}

/// Largest working set of this process so far [B].
pub fn peak_memory() -> Option<usize> {
    let size = u32::try_from(size_of::<PROCESS_MEMORY_COUNTERS>()).ok()?;
    let mut found = PROCESS_MEMORY_COUNTERS { cb: size, ..Default::default() };
    // SAFETY: the structure is of the size that is given
    let done = unsafe { GetProcessMemoryInfo(GetCurrentProcess(), &raw mut found, size) };
    (done != 0).then_some(found.PeakWorkingSetSize)
}

/// Memory that this process may still take [B]: what is free of the machine's.
pub fn available_memory() -> Option<usize> {
    let size = u32::try_from(size_of::<MEMORYSTATUSEX>()).ok()?;
    let mut found = MEMORYSTATUSEX { dwLength: size, ..Default::default() };
    // SAFETY: the structure knows its size
    let done = unsafe { GlobalMemoryStatusEx(&raw mut found) };
    (done != 0).then(|| usize::try_from(found.ullAvailPhys).unwrap_or(usize::MAX))
}
