//! Remainders of series whose leading terms cancel near zero.
//!
//! An energy is of second order in strain, but its textbook formula is a
//! difference of terms of first order or of order one; these functions keep
//! its digits.

use std::ops::{Add, Div, Mul, Sub};

/// Largest |x| for the series of [`ln_1p_minus`].
pub const LN_SERIES: f64 = 0.25;
/// Largest |x| for the series of [`exp_m1_minus`].
pub const EXP_SERIES: f64 = 0.5;

/// A number, or several side by side.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// A constant, as such a number.
    fn constant(self, value: f64) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }
}

/// ln(1 + x) − x.
pub fn ln_1p_minus(x: f64) -> f64 {
    if x.abs() > LN_SERIES {
        return x.ln_1p() - x;
    }
    ln_1p_minus_series(x)
}

/// eˣ − 1 − x.
pub fn exp_m1_minus(x: f64) -> f64 {
    if x.abs() > EXP_SERIES {
        return x.exp_m1() - x;
    }
    exp_m1_minus_series(x)
}

/// ln(1 + x) − x for |x| ≤ [`LN_SERIES`].
///
/// With r = x/(2 + x): ln(1 + x) = 2(r + r³/3 + r⁵/5 + …), and 2r − x = −r x.
#[inline(always)]
pub fn ln_1p_minus_series<T: Number>(x: T) -> T {
    let r = x / (x.constant(2.0) + x);
    let r2 = r * r;
    // |r²| ≤ 0.0205: eleven terms reach 1e-18
    let mut tail = x.constant(0.0);
    for k in (1..=11).rev() {
        tail = (tail + x.constant(1.0 / f64::from(2 * k + 1))) * r2;
    }
    x.constant(2.0) * r * tail - r * x
}

/// eˣ − 1 − x for |x| ≤ [`EXP_SERIES`].
#[inline(always)]
pub fn exp_m1_minus_series<T: Number>(x: T) -> T {
    // x²/2 (1 + x/3 (1 + x/4 (1 + …))); sixteen factors reach 1e-18
    let mut tail = x.constant(1.0);
    for k in (3..=16).rev() {
        tail = x.constant(1.0) + tail * (x * x.constant(1.0 / f64::from(k)));
    }
    x.constant(0.5) * x * x * tail
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_meet_their_series_near_zero() {
        for x in [1e-12, -1e-9, 3e-7, -1e-5] {
            let log = x * x * (-0.5 + x * (1.0 / 3.0 - x / 4.0));
            let exp = x * x * (0.5 + x * (1.0 / 6.0 + x / 24.0));
            assert!((ln_1p_minus(x) / log - 1.0).abs() < 1e-15);
            assert!((exp_m1_minus(x) / exp - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn both_meet_the_direct_formula_where_it_is_exact() {
        // the direct formula loses a factor 1/x, so to 1e-14 it may be used here
        for x in [-0.7, -0.5, -0.26, -0.24, -0.1, 0.1, 0.2, 0.249, 0.251, 0.49, 0.51, 3.0_f64] {
            assert!((ln_1p_minus(x) / (x.ln_1p() - x) - 1.0).abs() < 1e-14, "{x}");
            assert!((exp_m1_minus(x) / (x.exp_m1() - x) - 1.0).abs() < 1e-14, "{x}");
        }
    }
}
