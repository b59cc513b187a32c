//! Memory of this process.

use std::path::Path;

/// Largest resident set of this process so far [MiB]; `None` where the system does not
/// report it (other than Linux).
#[must_use]
pub fn peak_rss_mb() -> Option<f64> {
    let status = mesh::io::read_own_text(Path::new("/proc/self/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_that_of_what_was_held() {
        let Some(before) = peak_rss_mb() else { return };
        let held = vec![1_u8; 200 << 20];
        let sum: usize = held.iter().step_by(4096).map(|&x| x as usize).sum();
        let after = peak_rss_mb().unwrap_or_default();
        assert!(sum > 0 && after >= 200.0 && after > before, "{before} MB, then {after} MB");
    }
}
