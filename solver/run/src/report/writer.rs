//! Writes the results of a run on a thread of its own, while the next step is computed.

use std::sync::mpsc::{SyncSender, sync_channel};

use anyhow::{Context, Result};
use mechanics::forward::{Clock, Time};

use super::record::{Finished, Recorder};

/// Time steps that wait to be written, at most: each holds its states in memory.
const WAITING: usize = 1;

/// Takes what is to be written.
pub struct Writer {
    sender: SyncSender<Finished>,
    waited: Time,
}

impl Writer {
    /// Hands over a time step. Waits while others are not written yet.
    pub fn send(&mut self, finished: Finished) -> Result<()> {
        let clock = Clock::start();
        let sent = self.sender.send(finished);
        self.waited += clock.elapsed();
        sent.ok().context("a step before this one was not written")
    }
}

/// The result of a computation that hands its steps to a writer, and the time for which it
/// waited for files. All steps are written when this returns.
///
/// The writer has a pool of one thread: it neither waits for the threads that compute nor
/// takes their work.
pub fn write_beside<T>(
    recorder: &mut Recorder,
    compute: impl FnOnce(&mut Writer) -> Result<T>,
) -> Result<(T, Time)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel::<Finished>(WAITING);
        let write = move || receiver.iter().try_for_each(|finished| recorder.write(finished));
        let thread = scope.spawn(move || pool.install(write));
        let mut writer = Writer { sender, waited: Time::default() };
        let computed = compute(&mut writer);
        let Writer { sender, mut waited } = writer;
        drop(sender);
        let clock = Clock::start();
        // if it failed, that is why the computation ended
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        waited += clock.elapsed();
        Ok((computed?, waited))
    })
}
