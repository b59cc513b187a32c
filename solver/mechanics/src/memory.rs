//! Memory that a factorisation needs.

use serde::Serialize;

/// What a direct solution needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Need {
    /// Unknowns of the linear system.
    pub unknowns: usize,
    /// Numbers in its factor.
    pub factor_entries: usize,
    /// The factor and what is stored beside it [B].
    pub bytes: usize,
}

/// The factorisation does not fit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{} unknowns: the factor has {:.1} million entries and {} are needed, available are {}\n  use a coarser mesh, a lower degree, or a machine with more memory",
    need.unknowns, need.factor_entries as f64 / 1e6, size(need.bytes), size(*available)
)]
pub struct TooLarge {
    /// What is needed.
    pub need: Need,
    /// What is available [B].
    pub available: usize,
}

impl std::iter::Sum for Need {
    fn sum<I: Iterator<Item = Self>>(needs: I) -> Self {
        let none = Self { unknowns: 0, factor_entries: 0, bytes: 0 };
        needs.fold(none, |a, b| Self {
            unknowns: a.unknowns + b.unknowns,
            factor_entries: a.factor_entries + b.factor_entries,
            bytes: a.bytes + b.bytes,
        })
    }
}

impl Need {
    /// Whether this fits into `available` bytes, if that is known.
    pub fn check(self, available: Option<usize>) -> Result<(), TooLarge> {
        match available {
            Some(available) if self.bytes > available => Err(TooLarge { need: self, available }),
            _ => Ok(()),
        }
    }

    /// What a user should know before the first factorisation.
    pub fn describe(&self, available: Option<usize>) -> String {
        let of = available.map_or_else(String::new, |a| format!(" of {} available", size(a)));
        format!(
            "{} unknowns, factor of {:.1} million entries, {} of memory needed{of}",
            self.unknowns,
            self.factor_entries as f64 / 1e6,
            size(self.bytes),
        )
    }
}

fn size(bytes: usize) -> String {
    let megabytes = bytes as f64 / 1e6;
    if megabytes < 1e3 {
        format!("{megabytes:.0} MB")
    } else {
        format!("{:.2} GB", megabytes / 1e3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEED: Need = Need { unknowns: 1000, factor_entries: 5_000_000, bytes: 60_000_000 };

    #[test]
    fn what_does_not_fit_is_reported_with_numbers() {
        assert!(NEED.check(None).is_ok() && NEED.check(Some(60_000_000)).is_ok());
        let line = NEED.describe(Some(23_400_000_000));
        assert!(line.ends_with("60 MB of memory needed of 23.40 GB available"), "{line}");
        let text = NEED.check(Some(50_000_000)).expect_err("too little").to_string();
        for word in
            ["1000 unknowns", "5.0 million", "60 MB are needed", "50 MB", "coarser", "degree"]
        {
            assert!(text.contains(word), "{text}");
        }
    }
}
