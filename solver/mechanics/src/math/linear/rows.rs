//! Numbers of several systems side by side: what is read once of a matrix or a factor serves all of them.

use pulp::Simd;

use super::scalar::Scalar;
use super::unknown::{PANEL, Unknown, each};

/// Systems that are solved side by side: in single precision they fill the widest vector.
pub const SYSTEMS: usize = 16;

/// A number of each system.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Row<T>(pub [T; SYSTEMS]);

impl<T: Scalar> Unknown<T> for Row<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self([T::narrow(0.0); SYSTEMS])
    }

    #[inline(always)]
    fn plus(mut self, scale: T, x: Self) -> Self {
        self.0.iter_mut().zip(x.0).for_each(|(y, x)| *y += scale * x);
        self
    }

    #[inline(always)]
    fn times(mut self, scale: T) -> Self {
        self.0.iter_mut().for_each(|y| *y *= scale);
        self
    }

    #[inline(always)]
    fn subtract<S: Simd>(simd: S, l: [&[T]; PANEL], x: [Self; PANEL], y: &mut [Self]) {
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

    #[inline(always)]
    fn products<S: Simd>(simd: S, l: [&[T]; PANEL], y: &[Self]) -> [Self; PANEL] {
        let ctx = T::simd_ctx(simd);
        let mut all = [Self::zero(); PANEL];
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
