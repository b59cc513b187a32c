//! Numbers of a factor, and indices of its entries.

use std::ops::{AddAssign, Div, Mul, Neg, SubAssign};

use faer::traits::RealField;
use pulp::Simd;

/// Precision of a factor.
pub trait Scalar:
    RealField
    + Copy
    + AddAssign
    + SubAssign
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Relative error of a pivot by rounding, about.
    const PIVOT_ROUNDING: f64;
    /// The nearest number.
    fn narrow(value: f64) -> Self;
    /// This number in double precision.
    fn widen(self) -> f64;
    /// Reads numbers as vectors, from the first on; numbers that fill no whole vector are left out.
    fn vectors<S: Simd>(numbers: &[Self]) -> &[Self::SimdVec<S>];
    /// Does what [`Self::vectors`] does, for numbers that change.
    fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [Self::SimdVec<S>];
    /// Selects the first `count` lanes of a vector.
    fn first<S: Simd>(simd: S, count: usize) -> Self::SimdMask<S>;
}

impl Scalar for f64 {
    const PIVOT_ROUNDING: f64 = 1e-15;

    fn widen(self) -> f64 {
        self
    }

    fn narrow(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn vectors<S: Simd>(numbers: &[Self]) -> &[S::f64s] {
        S::as_simd_f64s(numbers).0
    }

    #[inline(always)]
    fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [S::f64s] {
        S::as_mut_simd_f64s(numbers).0
    }

    #[inline(always)]
    fn first<S: Simd>(simd: S, count: usize) -> S::m64s {
        simd.mask_between_m64s(0, count as u64).mask()
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

    #[inline(always)]
    fn vectors<S: Simd>(numbers: &[Self]) -> &[S::f32s] {
        S::as_simd_f32s(numbers).0
    }

    #[inline(always)]
    fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [S::f32s] {
        S::as_mut_simd_f32s(numbers).0
    }

    #[inline(always)]
    fn first<S: Simd>(simd: S, count: usize) -> S::m32s {
        simd.mask_between_m32s(0, count as u32).mask()
    }
}

/// An index in half the memory.
pub(super) fn narrow(i: usize) -> u32 {
    u32::try_from(i).expect("less than 2^32 entries")
}
