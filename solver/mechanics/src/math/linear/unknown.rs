//! What stands at a position of a vector: a number, or a number of each of several systems.

use pulp::Simd;

use super::scalar::Scalar;

/// Columns of a panel.
pub(super) const PANEL: usize = 4;

/// One unknown, of one system or of several.
pub trait Unknown<T>: Copy + Send + Sync {
    /// 0.
    fn zero() -> Self;
    /// `self` + scale x.
    fn plus(self, scale: T, x: Self) -> Self;
    /// scale `self`.
    fn times(self, scale: T) -> Self;
    /// y ← y − L x with a panel L, where rows have a column each.
    fn subtract<S: Simd>(simd: S, l: [&[T]; PANEL], x: [Self; PANEL], y: &mut [Self]);
    /// Lᵀ y.
    fn products<S: Simd>(simd: S, l: [&[T]; PANEL], y: &[Self]) -> [Self; PANEL];
}

impl<T: Scalar> Unknown<T> for T {
    #[inline(always)]
    fn zero() -> Self {
        T::narrow(0.0)
    }

    #[inline(always)]
    fn plus(self, scale: T, x: Self) -> Self {
        self + scale * x
    }

    #[inline(always)]
    fn times(self, scale: T) -> Self {
        scale * self
    }

    /// Vectors are counted from the end of y, as all panels of a front do: then they load what one
    /// store wrote. The first vector overlaps the second, where both find the same numbers.
    #[inline(always)]
    fn subtract<S: Simd>(simd: S, l: [&[T]; PANEL], x: [T; PANEL], y: &mut [T]) {
        let odd = y.len() % lanes::<T, S>();
        if odd == y.len() {
            for (l, x) in l.into_iter().zip(x) {
                y.iter_mut().zip(l).for_each(|(y, &l)| *y -= l * x);
            }
            return;
        }
        let ctx = T::simd_ctx(simd);
        let minus = each(x, |x| T::simd_splat(&ctx, &-x));
        let less = |y: T::SimdVec<S>, [a, b, c, d]: [&T::SimdVec<S>; PANEL]| {
            let y = T::simd_mul_add(&ctx, *a, minus[0], y);
            let y = T::simd_mul_add(&ctx, *b, minus[1], y);
            let y = T::simd_mul_add(&ctx, *c, minus[2], y);
            T::simd_mul_add(&ctx, *d, minus[3], y)
        };
        let start = less(T::vectors::<S>(y)[0], each(l, |l| &T::vectors::<S>(l)[0]));
        let whole = each(l, |l| T::vectors::<S>(&l[odd..]));
        let second = less(T::vectors::<S>(&y[odd..])[0], each(whole, |l| &l[0]));
        T::vectors_mut::<S>(y)[0] = start;
        let y = T::vectors_mut::<S>(&mut y[odd..]);
        y[0] = second;
        let [a, b, c, d] = each(whole, |l| &l[1..]);
        for ((((y, a), b), c), d) in y[1..].iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *y = less(*y, [a, b, c, d]);
        }
    }

    /// The numbers that were found last come first in y. They are loaded last.
    #[inline(always)]
    fn products<S: Simd>(simd: S, l: [&[T]; PANEL], y: &[T]) -> [T; PANEL] {
        let odd = y.len() % lanes::<T, S>();
        if odd == y.len() {
            return each(l, |l| {
                let mut sum = T::narrow(0.0);
                y.iter().zip(l).for_each(|(&y, &l)| sum += y * l);
                sum
            });
        }
        let ctx = T::simd_ctx(simd);
        let zero = T::simd_splat(&ctx, &T::narrow(0.0));
        let add = |sums: [T::SimdVec<S>; PANEL], y: T::SimdVec<S>, l: [&T::SimdVec<S>; PANEL]| {
            let add = |j: usize| T::simd_mul_add(&ctx, *l[j], y, sums[j]);
            [add(0), add(1), add(2), add(3)]
        };
        let mut sums = [zero; PANEL];
        let [a, b, c, d] = each(l, |l| T::vectors::<S>(&l[odd..]));
        for ((((y, a), b), c), d) in T::vectors::<S>(&y[odd..]).iter().zip(a).zip(b).zip(c).zip(d) {
            sums = add(sums, *y, [a, b, c, d]);
        }
        let start = T::simd_select(&ctx, T::first::<S>(simd, odd), T::vectors::<S>(y)[0], zero);
        sums = add(sums, start, each(l, |l| &T::vectors::<S>(l)[0]));
        each(sums, |sum| T::simd_reduce_sum(&ctx, sum))
    }
}

/// `map` of an array, which the standard library does not always inline.
#[inline(always)]
pub(super) fn each<A, B>([a, b, c, d]: [A; PANEL], f: impl Fn(A) -> B) -> [B; PANEL] {
    [f(a), f(b), f(c), f(d)]
}

/// Numbers in a vector.
#[inline(always)]
const fn lanes<T: Scalar, S: Simd>() -> usize {
    size_of::<T::SimdVec<S>>() / size_of::<T>()
}
