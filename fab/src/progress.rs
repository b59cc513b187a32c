//! What a long run is doing, on standard error.

use std::time::Instant;

use log::Level;

/// Bodies with fewer boundary triangles are done before a person wonders.
const LARGE: usize = 100_000;

/// A clock, and the level at which it logs.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    start: Instant,
    level: Level,
}

impl Progress {
    /// Logs every step of a large body; those of small ones at debug level.
    #[must_use]
    pub fn new(triangles: usize) -> Self {
        let level = if triangles >= LARGE { Level::Info } else { Level::Debug };
        Self { start: Instant::now(), level }
    }

    /// Logs a step that begins, the time, and the largest memory until now.
    pub fn step(&self, what: &str) {
        let seconds = self.start.elapsed().as_secs_f64();
        let memory = peak_memory().map_or(String::new(), |mb| format!(", {mb:.0} MB"));
        log::log!(self.level, "[{seconds:.1} s{memory}] {what}");
    }
}

/// Largest memory that this process has held [MB], where the system reports it (Linux).
#[must_use]
pub fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_that_of_what_was_held() {
        let Some(before) = peak_memory() else { return };
        let held = vec![1_u8; 200 << 20];
        let sum: usize = held.iter().step_by(4096).map(|&x| x as usize).sum();
        let after = peak_memory().unwrap_or_default();
        assert!(sum > 0 && after >= 200.0 && after > before, "{before} MB, then {after} MB");
    }
}
