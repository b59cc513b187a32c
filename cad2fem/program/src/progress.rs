//! Messages about the progress of long work, on standard error.

use std::cell::Cell;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use log::Level;

use crate::memory::peak_rss_mb;

/// Inputs with fewer triangles are processed within seconds.
const LARGE: usize = 100_000;
/// Time between two messages of a [`Heartbeat`].
const HEARTBEAT: Duration = Duration::from_secs(10);

/// Reports the steps of a program with the time since its start.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    start: Instant,
    level: Level,
}

impl Progress {
    /// Starts the clock. Steps are reported at the level `info` for inputs of at least
    /// 100 000 triangles, and at the level `debug` for smaller ones.
    pub fn new(triangles: usize) -> Self {
        let level = if triangles >= LARGE { Level::Info } else { Level::Debug };
        Self { start: Instant::now(), level }
    }

    /// Reports the step that begins, the time since the start, and the peak memory.
    pub fn step(&self, what: &str) {
        let seconds = self.start.elapsed().as_secs_f64();
        let memory = peak_rss_mb().map_or(String::new(), |mb| format!(", {mb:.0} MB"));
        log::log!(self.level, "[{seconds:.1} s{memory}] {what}");
    }
}

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

/// Reports the time that a single job has taken: live on a terminal, else one line every
/// ten seconds.
pub struct Spinner {
    title: &'static str,
    bar: Option<ProgressBar>,
    reported: Cell<u64>,
}

impl Spinner {
    /// A spinner for the job `title`.
    pub fn new(title: &'static str) -> Self {
        let live = std::io::stderr().is_terminal() && log::log_enabled!(Level::Info);
        let bar = live.then(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
            ProgressBar::new_spinner().with_style(style)
        });
        Self { title, bar, reported: 0.into() }
    }

    /// Reports the elapsed time; called several times per second.
    pub fn show(&self, elapsed: Duration) {
        let message = format!("{}  {} s", self.title, elapsed.as_secs());
        match &self.bar {
            Some(bar) => {
                bar.set_message(message);
                bar.tick();
            }
            None if elapsed.as_secs() >= self.reported.get() + 10 => {
                self.reported.set(elapsed.as_secs());
                log::info!("{message}");
            }
            None => {}
        }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
