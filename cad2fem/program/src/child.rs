//! Programs that ours runs, and that end with it.

use std::io;
use std::path::PathBuf;
use std::process::{Child, ChildStderr, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// A program of ours: beside the one that runs, or else on the path.
pub fn beside(name: &str) -> PathBuf {
    let name = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().map(|own| own.with_file_name(&name));
    beside.ok().filter(|path| path.exists()).unwrap_or_else(|| PathBuf::from(name))
}

/// A program that runs until it ends, is killed, or ours is interrupted.
pub struct Process(Arc<Mutex<Child>>);

static RUNNING: Mutex<Vec<Weak<Mutex<Child>>>> = Mutex::new(Vec::new());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Process {
    /// Starts it.
    pub fn spawn(command: &mut Command) -> io::Result<Self> {
        system::unblock_in(command);
        let mut running = lock(&RUNNING); // an interruption waits until it is known
        let child = Arc::new(Mutex::new(command.spawn()?));
        running.retain(|other| other.strong_count() > 0);
        running.push(Arc::downgrade(&child));
        Ok(Self(child))
    }

    /// The standard error, if that is a pipe; once.
    pub fn take_stderr(&self) -> Option<ChildStderr> {
        lock(&self.0).stderr.take()
    }

    /// How it ended, if it has.
    pub fn try_wait(&self) -> io::Result<Option<ExitStatus>> {
        lock(&self.0).try_wait()
    }

    /// Waits for its end.
    pub fn wait(&self) -> io::Result<ExitStatus> {
        lock(&self.0).wait()
    }

    /// Ends it.
    pub fn kill(&self) -> io::Result<()> {
        let mut child = lock(&self.0);
        child.kill()?;
        child.wait().map(drop)
    }
}

/// Ends all that run. While the result is held none is started.
pub fn kill_all() -> impl Sized {
    let running = lock(&RUNNING);
    for child in running.iter().filter_map(Weak::upgrade) {
        // a child that is gone already is as good; one that is waited for is about to be gone
        if let Ok(mut child) = child.try_lock() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
    running
}
