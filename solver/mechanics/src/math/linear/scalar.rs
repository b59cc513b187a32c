//! Numbers of a factor, and indices of its entries.

use std::ops::{AddAssign, Mul, SubAssign};

use faer::traits::RealField;

/// Precision of a factor.
pub trait Scalar: RealField + Copy + AddAssign + SubAssign + Mul<Output = Self> {
    /// Relative error of a pivot by rounding, about.
    const PIVOT_ROUNDING: f64;
    /// The nearest number.
    fn narrow(value: f64) -> Self;
    /// This number in double precision.
    fn widen(self) -> f64;
}

impl Scalar for f64 {
    const PIVOT_ROUNDING: f64 = 1e-15;

    fn widen(self) -> f64 {
        self
    }

    fn narrow(value: f64) -> Self {
        value
    }
}

impl Scalar for f32 {
    const PIVOT_ROUNDING: f64 = 1e-6;

    fn widen(self) -> f64 {
        f64::from(self)
    }

    #[allow(clippy::cast_possible_truncation)]
    fn narrow(value: f64) -> Self {
        value as Self
    }
}

/// An index in half the memory.
pub(super) fn narrow(i: usize) -> u32 {
    u32::try_from(i).expect("less than 2^32 entries")
}
