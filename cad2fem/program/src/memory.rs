//! Memory of this process.

/// Largest resident set of this process so far [MiB]; `None` where the system does not report it.
pub fn peak_rss_mb() -> Option<f64> {
    #[allow(clippy::cast_precision_loss, reason = "a number of bytes far below 2^53")]
    system::peak_memory().map(|bytes| bytes as f64 / 1_048_576.0)
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
