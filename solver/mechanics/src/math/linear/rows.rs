//! Numbers of several systems side by side: what is read once of a matrix or a factor serves all of them.

use pulp::{Simd, WithSimd};

use super::columns::{Columns, PANEL, each, reciprocals};
use super::scalar::Scalar;
use crate::math::lanes::widest;

/// Systems that are solved side by side: in single precision they fill the widest vector.
pub const SYSTEMS: usize = 16;

/// A number of each system.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Row<T>(pub [T; SYSTEMS]);

impl<T: Scalar> Row<T> {
    /// Zeros.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([T::narrow(0.0); SYSTEMS])
    }

    /// `self` + scale x, with one scale for all.
    #[inline(always)]
    pub fn plus(mut self, scale: T, x: Self) -> Self {
        self.0.iter_mut().zip(x.0).for_each(|(y, x)| *y += scale * x);
        self
    }

    #[inline(always)]
    fn times(mut self, scale: T) -> Self {
        self.0.iter_mut().for_each(|y| *y *= scale);
        self
    }
}

/// Substitution with one panel of columns after the other, as [`super::columns`] has it for one system.
pub(super) enum Work<'a, T> {
    /// x₁ ← L₁₁⁻¹ x₁ and x₂ ← x₂ − L₂₁ x₁.
    Forward(&'a mut [Row<T>]),
    /// x₁ ← L₁₁⁻ᵀ (x₁ − L₂₁ᵀ x₂).
    Backward(&'a mut [Row<T>]),
    /// y ← y − L x.
    Subtract { x: &'a [Row<T>], y: &'a mut [Row<T>] },
    /// x ← x − Lᵀ y.
    SubtractTransposed { y: &'a [Row<T>], x: &'a mut [Row<T>] },
}

/// Does it with the rows of some columns from one on.
pub(super) fn substitute<T: Scalar>(columns: Columns<'_, T>, row: usize, work: Work<'_, T>) {
    widest(Substitute { columns, row, work });
}

struct Substitute<'a, T> {
    columns: Columns<'a, T>,
    row: usize,
    work: Work<'a, T>,
}

impl<T: Scalar> WithSimd for Substitute<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { columns, row, work } = self;
        match work {
            Work::Forward(x) => {
                for (first, count) in columns.panels() {
                    let x = &mut x[first..];
                    forward(simd, columns.panel(first, row + first, x.len()), count, x);
                }
            }
            Work::Backward(x) => {
                for (first, count) in columns.panels().rev() {
                    let x = &mut x[first..];
                    backward(simd, columns.panel(first, row + first, x.len()), count, x);
                }
            }
            Work::Subtract { x, y } => {
                for (first, count) in columns.panels() {
                    let mut by = [Row::zero(); PANEL];
                    by[..count].copy_from_slice(&x[first..][..count]);
                    subtract(simd, columns.panel(first, row, y.len()), by, y);
                }
            }
            Work::SubtractTransposed { y, x } => {
                for (first, count) in columns.panels() {
                    let sums = products(simd, columns.panel(first, row, y.len()), y);
                    let minus = T::narrow(-1.0);
                    for (x, sum) in x[first..].iter_mut().zip(&sums[..count]) {
                        *x = x.plus(minus, *sum);
                    }
                }
            }
        }
    }
}

/// A panel, by its first rows.
#[inline(always)]
fn forward<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], count: usize, x: &mut [Row<T>]) {
    let (own, below) = x.split_at_mut(count);
    let (scale, mut solved) = (reciprocals(l, count), [Row::zero(); PANEL]);
    for j in 0..count {
        let mut row = own[j];
        for i in 0..j {
            row = row.plus(-l[i][j], solved[i]);
        }
        solved[j] = row.times(scale[j]);
        own[j] = solved[j];
    }
    subtract(simd, each(l, |l| &l[count..]), solved, below);
}

#[inline(always)]
fn backward<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], count: usize, x: &mut [Row<T>]) {
    let (own, below) = x.split_at_mut(count);
    let sums = products(simd, each(l, |l| &l[count..]), below);
    let scale = reciprocals(l, count);
    for j in (0..count).rev() {
        let mut row = own[j].plus(T::narrow(-1.0), sums[j]);
        for i in j + 1..count {
            row = row.plus(-l[j][i], own[i]);
        }
        own[j] = row.times(scale[j]);
    }
}

/// y ← y − L x.
#[inline(always)]
fn subtract<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], x: [Row<T>; PANEL], y: &mut [Row<T>]) {
    let ctx = T::simd_ctx(simd);
    let x = each(x, |x| x.times(T::narrow(-1.0)));
    for k in 0..vectors::<T, S>() {
        let x = [part::<T, S>(&x[0], k), part(&x[1], k), part(&x[2], k), part(&x[3], k)];
        let [a, b, c, d] = l;
        for ((((y, a), b), c), d) in y.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            let y = &mut T::vectors_mut::<S>(&mut y.0)[k];
            let sum = T::simd_mul_add(&ctx, T::simd_splat(&ctx, a), x[0], *y);
            let sum = T::simd_mul_add(&ctx, T::simd_splat(&ctx, b), x[1], sum);
            let sum = T::simd_mul_add(&ctx, T::simd_splat(&ctx, c), x[2], sum);
            *y = T::simd_mul_add(&ctx, T::simd_splat(&ctx, d), x[3], sum);
        }
    }
}

/// Lᵀ y.
#[inline(always)]
fn products<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], y: &[Row<T>]) -> [Row<T>; PANEL] {
    let ctx = T::simd_ctx(simd);
    let mut all = [Row::zero(); PANEL];
    for k in 0..vectors::<T, S>() {
        let mut sums = [T::simd_splat(&ctx, &T::narrow(0.0)); PANEL];
        let [a, b, c, d] = l;
        for ((((y, a), b), c), d) in y.iter().zip(a).zip(b).zip(c).zip(d) {
            let y = part::<T, S>(y, k);
            sums[0] = T::simd_mul_add(&ctx, T::simd_splat(&ctx, a), y, sums[0]);
            sums[1] = T::simd_mul_add(&ctx, T::simd_splat(&ctx, b), y, sums[1]);
            sums[2] = T::simd_mul_add(&ctx, T::simd_splat(&ctx, c), y, sums[2]);
            sums[3] = T::simd_mul_add(&ctx, T::simd_splat(&ctx, d), y, sums[3]);
        }
        for (row, sum) in all.iter_mut().zip(sums) {
            T::vectors_mut::<S>(&mut row.0)[k] = sum;
        }
    }
    all
}

#[inline(always)]
fn part<T: Scalar, S: Simd>(row: &Row<T>, k: usize) -> T::SimdVec<S> {
    T::vectors::<S>(&row.0)[k]
}

/// Vectors in a row.
#[inline(always)]
const fn vectors<T: Scalar, S: Simd>() -> usize {
    SYSTEMS * size_of::<T>() / size_of::<T::SimdVec<S>>()
}
