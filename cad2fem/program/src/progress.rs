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

/// A time as people say it, with one or two digits.
pub fn about(seconds: f64) -> String {
    match seconds {
        s if s < 1.5 => "a second".into(),
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 90.0 * 60.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_said_with_the_digits_they_have() {
        let said = [0.2, 41.3, 89.0, 91.0, 3500.0, 7300.0].map(about);
        assert_eq!(said, ["a second", "41 s", "89 s", "2 min", "58 min", "2.0 h"]);
    }
}
