//! Whether a factorisation fits into the memory that the machine has left. Where a system does not say how much that
//! is, nothing is refused.

use mechanics::memory::Need;
use program::Unusable;
use system::available_memory;

/// Whether a factorisation fits into the memory that is left.
///
/// # Errors
/// [`Unusable`] if it does not: the input may be sound, and another machine can run it.
pub fn require(need: Need) -> Result<(), Unusable> {
    need.check(available_memory()).map_err(|too_large| Unusable(too_large.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_no_error_of_the_input() {
        let need = |bytes| Need { unknowns: 9, factor_entries: 45, bytes };
        assert!(require(need(1)).is_ok());
        if available_memory().is_some() {
            let Unusable(message) = require(need(usize::MAX)).expect_err("does not fit");
            assert!(message.contains("a machine with more memory"), "{message}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn linux_reports_memory() {
        assert!(available_memory().is_some_and(|bytes| bytes > 1 << 20));
    }
}
