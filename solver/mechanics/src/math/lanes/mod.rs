//! Numbers side by side, one of each of several elements: a vector instruction for all of
//! them.
//!
//! Each lane is computed as one number alone would be: sums and products round one by one,
//! but for [`Lanes::mul_add`], which rounds once on every machine. A result has the same
//! bits however many lanes there are.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use pulp::Simd;

pub mod projection;
pub mod tensor;

/// Lanes of the widest vectors, at most.
pub const MOST: usize = 8;

/// Largest |x| for the series of ln(1 + x) − x.
const LN_SERIES: f64 = 0.25;
/// Largest |x| for the series of eˣ − 1 − x.
const EXP_SERIES: f64 = 0.5;

/// Work that gains from vectors. Its implementation of `with_simd` has to be marked
/// `#[inline(always)]`, and so have the functions it calls: only what is inlined is
/// compiled for the vectors.
pub use pulp::WithSimd;

/// One lane, for a number alone.
pub use pulp::Scalar;

/// Does the work with the widest vectors of this machine.
pub fn widest<W: WithSimd>(work: W) -> W::Output {
    pulp::Arch::new().dispatch(work)
}

/// A number in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd> {
    simd: S,
    values: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// Number of lanes.
    pub const COUNT: usize = S::F64_LANES;

    /// A number that is the same in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Self { simd, values: simd.splat_f64s(x) }
    }

    /// From the first numbers of a buffer.
    #[inline(always)]
    pub fn load(simd: S, from: &[f64; MOST]) -> Self {
        Self { simd, values: S::as_simd_f64s(from).0[0] }
    }

    /// To the first numbers of a buffer.
    #[inline(always)]
    pub fn store(self, to: &mut [f64; MOST]) {
        S::as_mut_simd_f64s(to).0[0] = self.values;
    }

    /// The numbers, with anything in those beyond the lanes.
    #[inline(always)]
    pub fn to_array(self) -> [f64; MOST] {
        let mut values = [0.0; MOST];
        self.store(&mut values);
        values
    }

    /// `self` · `by` + `to`, rounded once.
    #[inline(always)]
    pub fn mul_add(self, by: Self, to: Self) -> Self {
        let values = self.simd.mul_add_f64s(self.values, by.values, to.values);
        Self { simd: self.simd, values }
    }

    /// 1 / `self`.
    #[inline(always)]
    pub fn recip(self) -> Self {
        Self::splat(self.simd, 1.0) / self
    }

    /// √`self`.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { simd: self.simd, values: self.simd.sqrt_f64s(self.values) }
    }

    /// |`self`|.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { simd: self.simd, values: self.simd.abs_f64s(self.values) }
    }

    /// In each lane `yes` where the number is positive, else `no`, also for NaN.
    #[inline(always)]
    pub fn if_positive(self, yes: Self, no: Self) -> Self {
        let simd = self.simd;
        let mask = simd.greater_than_f64s(self.values, simd.splat_f64s(0.0));
        Self { simd, values: simd.select_f64s(mask, yes.values, no.values) }
    }

    /// Zero in all lanes.
    #[inline(always)]
    pub fn zero(self) -> Self {
        Self::splat(self.simd, 0.0)
    }

    /// The lesser of two numbers in each lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { simd: self.simd, values: self.simd.min_f64s(self.values, other.values) }
    }

    /// Whether a number is larger in magnitude than a limit.
    #[inline(always)]
    fn any_beyond(self, limit: f64) -> bool {
        let size = self.simd.abs_f64s(self.values);
        let beyond = self.simd.greater_than_f64s(size, self.simd.splat_f64s(limit));
        self.simd.first_true_m64s(beyond) < Self::COUNT
    }

    /// ln(1 + x) − x, with its digits near zero, where the leading terms cancel.
    ///
    /// With r = x/(2 + x): ln(1 + x) = 2(r + r³/3 + r⁵/5 + …), and 2r − x = −r x.
    #[inline(always)]
    pub fn ln_1p_minus(self) -> Self {
        let r = self / (self + 2.0);
        let r2 = r * r;
        // |r²| ≤ 0.0205: eleven terms reach 1e-18
        let mut tail = self.zero();
        for k in (1..=11).rev() {
            tail = (tail + 1.0 / f64::from(2 * k + 1)) * r2;
        }
        self.or_beyond(r * 2.0 * tail - r * self, LN_SERIES, |x| x.ln_1p() - x)
    }

    /// eˣ − 1 − x, with its digits near zero.
    #[inline(always)]
    pub fn exp_m1_minus(self) -> Self {
        // x²/2 (1 + x/3 (1 + x/4 (1 + …))); sixteen factors reach 1e-18
        let mut tail = self.zero() + 1.0;
        for k in (3..=16).rev() {
            tail = tail * (self * (1.0 / f64::from(k))) + 1.0;
        }
        self.or_beyond(self * 0.5 * self * tail, EXP_SERIES, |x| x.exp_m1() - x)
    }

    /// `value` in the lanes whose number is within a limit, else a function of it.
    #[inline(always)]
    fn or_beyond(self, value: Self, limit: f64, function: impl Fn(f64) -> f64) -> Self {
        if !self.any_beyond(limit) {
            return value;
        }
        let (x, mut result) = (self.to_array(), value.to_array());
        for lane in 0..Self::COUNT {
            if x[lane].abs() > limit {
                result[lane] = function(x[lane]);
            }
        }
        Self::load(self.simd, &result)
    }
}

macro_rules! operator {
    ($operator:ident, $method:ident, $vector:ident) => {
        impl<S: Simd> $operator for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { simd: self.simd, values: self.simd.$vector(self.values, other.values) }
            }
        }

        impl<S: Simd> $operator<f64> for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::splat(self.simd, other))
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> SubAssign for Lanes<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { simd: self.simd, values: self.simd.neg_f64s(self.values) }
    }
}

/// [`Lanes::exp_m1_minus`] of a number alone.
pub fn exp_m1_minus(x: f64) -> f64 {
    Lanes::splat(Scalar, x).exp_m1_minus().to_array()[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ln_1p_minus(x: f64) -> f64 {
        Lanes::splat(Scalar, x).ln_1p_minus().to_array()[0]
    }

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
