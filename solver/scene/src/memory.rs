//! Whether a factorisation fits into the memory that the machine has left. Where a system does not say how much that
//! is, nothing is refused.

use mechanics::memory::Need;
use program::{Unusable, about};
use system::available_memory;

/// Entries of the factor of a compact body of n unknowns, over n^(4/3): cubes of degree 2 had 26 with 0.4 million and 28 with
/// 3.2 million unknowns. Thin walls have fewer.
const COMPACT: f64 = 28.0;
/// Memory of an entry, with what is stored beside it [B].
const ENTRY: f64 = 7.5;
/// Time to put an unknown in order, on one core [s].
const ORDERING: f64 = 1.1e-5;

/// What to say before the unknowns are put in order, which tells how much memory they need and takes long itself: where a
/// compact body of as many unknowns would not fit.
pub fn foretold(unknowns: usize) -> Option<String> {
    let n = unknowns as f64;
    let entries = COMPACT * n.powf(4.0 / 3.0);
    let need =
        Need { unknowns, factor_entries: entries as usize, bytes: (ENTRY * entries) as usize };
    let available = available_memory();
    need.check(available).is_err().then(|| {
        format!(
            "a compact body of as many would not fit: {}; what this one needs is known when they are in order, in about \
             {}\n  a lower degree or a coarser mesh needs less",
            need.describe(available),
            about(ORDERING * n)
        )
    })
}

/// Whether a factorisation fits into the memory that is left.
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

    /// A cube of 0.8 million tetrahedra of degree 2 took 35 s before it was refused for 99.85 GB.
    #[test]
    fn what_a_compact_body_cannot_have_is_said_before_it_is_in_order() {
        assert_eq!(foretold(2000), None);
        if available_memory().is_some_and(|bytes| bytes < 99_000_000_000) {
            let said = foretold(3_246_354).expect("too large");
            assert!(said.contains("3246354 unknowns") && said.contains("available"), "{said}");
        }
    }
}
