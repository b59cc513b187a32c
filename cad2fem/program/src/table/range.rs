//! Numbers that a key admits, and how a message says it.

use std::ops::Bound;

use super::Rule;
use crate::{KeyPath, Misfit};

/// Numbers that a key admits: between two bounds, and finite.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    low: Bound<f64>,
    high: Bound<f64>,
    unit: &'static str,
    advice: &'static str,
}

impl Range {
    /// Any finite number.
    pub const FINITE: Self =
        Self { low: Bound::Unbounded, high: Bound::Unbounded, unit: "", advice: "" };

    /// Above 0.
    pub const POSITIVE: Self = Self::above(0.0);

    /// At least 0.
    pub const NOT_NEGATIVE: Self = Self::at_least(0.0);

    /// Above `low`.
    pub const fn above(low: f64) -> Self {
        Self { low: Bound::Excluded(low), ..Self::FINITE }
    }

    /// At least `low`.
    pub const fn at_least(low: f64) -> Self {
        Self { low: Bound::Included(low), ..Self::FINITE }
    }

    /// From `low` to `high`.
    pub const fn between(low: f64, high: f64) -> Self {
        Self::at_least(low).at_most(high)
    }

    /// And below `high`.
    pub const fn below(self, high: f64) -> Self {
        Self { high: Bound::Excluded(high), ..self }
    }

    /// And at most `high`.
    pub const fn at_most(self, high: f64) -> Self {
        Self { high: Bound::Included(high), ..self }
    }

    /// The unit, as messages write it.
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// How messages go on, such as `"; such as 1e-4 for paper"`.
    pub const fn advice(self, advice: &'static str) -> Self {
        Self { advice, ..self }
    }

    /// Whether a number is admitted.
    pub fn contains(&self, number: f64) -> bool {
        number.is_finite() && std::ops::RangeBounds::contains(&(self.low, self.high), &number)
    }

    /// Refuses a number.
    pub fn admit(&self, at: &KeyPath, number: f64) -> Result<(), Misfit> {
        if self.contains(number) {
            return Ok(());
        }
        let (unit, advice) = (self.after_numbers(), self.advice);
        let words = self.words(number.is_finite());
        Err(at.clone().says(format!(" = {number}{unit}: must {words}{advice}")))
    }

    /// What is asked of a number, which may be finite already.
    fn words(&self, is_finite: bool) -> String {
        let unit = self.after_numbers();
        match (self.low, self.high) {
            (Bound::Excluded(0.0), Bound::Unbounded) => "be positive and finite".into(),
            (Bound::Included(0.0), Bound::Unbounded) => "be finite and not negative".into(),
            (Bound::Included(low), Bound::Included(high)) => {
                format!("lie between {low} and {high}{unit}")
            }
            (low, high) => {
                let above = match low {
                    Bound::Excluded(low) => Some(format!("above {low}")),
                    Bound::Included(low) => Some(format!("at least {low}")),
                    Bound::Unbounded => None,
                };
                let below = match high {
                    Bound::Excluded(high) => Some(format!("below {high}{unit}")),
                    Bound::Included(high) => Some(format!("at most {high}{unit}")),
                    Bound::Unbounded => (!is_finite).then(|| "finite".into()),
                };
                let both: Vec<String> = above.into_iter().chain(below).collect();
                format!("be {}", both.join(" and "))
            }
        }
    }

    /// The unit as it follows a number.
    fn after_numbers(&self) -> String {
        match self.unit {
            "" | "°" => self.unit.into(),
            unit => format!(" {unit}"),
        }
    }
}

impl<T: Numbers> Rule<T> for Range {
    fn check(&self, at: &KeyPath, value: &T) -> Result<(), Misfit> {
        value.numbers().into_iter().try_for_each(|number| self.admit(at, number))
    }
}

/// The numbers of a value, each of which a [`Range`] has to admit.
pub trait Numbers {
    /// All of them.
    fn numbers(&self) -> Vec<f64>;
}

impl Numbers for f64 {
    fn numbers(&self) -> Vec<f64> {
        vec![*self]
    }
}

impl Numbers for usize {
    #[allow(clippy::cast_precision_loss, reason = "counts in files are far below 2^53")]
    fn numbers(&self) -> Vec<f64> {
        vec![*self as f64]
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(T::numbers).collect()
    }
}

impl<T: Numbers> Numbers for Vec<T> {
    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(T::numbers).collect()
    }
}

impl<T: Numbers, const N: usize> Numbers for [T; N] {
    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(T::numbers).collect()
    }
}
