//! Messages about the progress of long work.

use std::time::{Duration, Instant};

/// Time between two messages of a [`Heartbeat`].
const HEARTBEAT: Duration = Duration::from_secs(10);

/// Says what long work has come to, now and then: work of less than ten seconds says nothing.
#[derive(Debug)]
pub struct Heartbeat {
    last: Instant,
}

impl Heartbeat {
    /// Starts the clock.
    pub fn start() -> Self {
        Self { last: Instant::now() }
    }

    /// Logs a message where the last one, or the start, is ten seconds ago.
    pub fn say(&mut self, message: impl FnOnce() -> String) {
        if self.last.elapsed() >= HEARTBEAT {
            log::info!("{}", message());
            self.last = Instant::now();
        }
    }
}
