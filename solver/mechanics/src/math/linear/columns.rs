//! Products and substitutions with columns of a front, by the widest vectors of this machine.
//!
//! All of them read each entry once and do little with it, so that memory is to limit them: the
//! columns go by panels of four, whose entries stream side by side while the vector they act on
//! stays in the cache. More streams than that, or fewer, are slower here.

use pulp::{Simd, WithSimd};

use super::scalar::Scalar;
use crate::math::lanes::widest;

/// Columns of a panel.
pub(super) const PANEL: usize = 4;

/// Columns of one height, one after the other.
#[derive(Clone, Copy)]
pub struct Columns<'a, T> {
    values: &'a [T],
    height: usize,
}

impl<'a, T: Scalar> Columns<'a, T> {
    /// From their entries.
    pub fn new(values: &'a [T], height: usize) -> Self {
        Self { values, height }
    }

    /// Number of columns.
    pub fn count(self) -> usize {
        self.values.len() / self.height
    }

    /// Some of the columns.
    pub fn part(self, first: usize, count: usize) -> Self {
        let values = &self.values[first * self.height..][..count * self.height];
        Self { values, ..self }
    }

    /// x₁ ← L₁₁⁻¹ x₁ and x₂ ← x₂ − L₂₁ x₁, where `x` holds x₁, one number for each column, and x₂
    /// below. The first row is `row`.
    pub fn forward(self, row: usize, x: &mut [T]) {
        widest(Forward { columns: self, row, x });
    }

    /// x₁ ← L₁₁⁻ᵀ (x₁ − L₂₁ᵀ x₂), with `x` as before.
    pub fn backward(self, row: usize, x: &mut [T]) {
        widest(Backward { columns: self, row, x });
    }

    /// y ← y − L x with the rows from `row` on.
    pub fn subtract(self, row: usize, x: &[T], y: &mut [T]) {
        widest(Subtract { columns: self, row, x, y });
    }

    /// x ← x − Lᵀ y with the rows from `row` on.
    pub fn subtract_transposed(self, row: usize, y: &[T], x: &mut [T]) {
        widest(SubtractTransposed { columns: self, row, y, x });
    }

    /// Panels of columns by the first column of each and their number.
    #[inline(always)]
    pub(super) fn panels(self) -> impl DoubleEndedIterator<Item = (usize, usize)> {
        let count = self.count();
        (0..count.div_ceil(PANEL)).map(move |p| (p * PANEL, PANEL.min(count - p * PANEL)))
    }

    /// A panel from a row on, cut to a length. Where it has fewer columns, the last one fills it up.
    #[inline(always)]
    pub(super) fn panel(self, first: usize, row: usize, len: usize) -> [&'a [T]; PANEL] {
        let last = self.count() - 1;
        let column = |j| &self.values[last.min(first + j) * self.height + row..][..len];
        [column(0), column(1), column(2), column(3)]
    }
}

struct Forward<'a, T> {
    columns: Columns<'a, T>,
    row: usize,
    x: &'a mut [T],
}

impl<T: Scalar> WithSimd for Forward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { columns, row, x } = self;
        for (first, count) in columns.panels() {
            let x = &mut x[first..];
            forward(simd, columns.panel(first, row + first, x.len()), count, x);
        }
    }
}

struct Backward<'a, T> {
    columns: Columns<'a, T>,
    row: usize,
    x: &'a mut [T],
}

impl<T: Scalar> WithSimd for Backward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { columns, row, x } = self;
        for (first, count) in columns.panels().rev() {
            let x = &mut x[first..];
            backward(simd, columns.panel(first, row + first, x.len()), count, x);
        }
    }
}

struct Subtract<'a, T> {
    columns: Columns<'a, T>,
    row: usize,
    x: &'a [T],
    y: &'a mut [T],
}

impl<T: Scalar> WithSimd for Subtract<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { columns, row, x, y } = self;
        for (first, count) in columns.panels() {
            let mut by = [T::narrow(0.0); PANEL];
            by[..count].copy_from_slice(&x[first..][..count]);
            subtract(simd, columns.panel(first, row, y.len()), by, y);
        }
    }
}

struct SubtractTransposed<'a, T> {
    columns: Columns<'a, T>,
    row: usize,
    y: &'a [T],
    x: &'a mut [T],
}

impl<T: Scalar> WithSimd for SubtractTransposed<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { columns, row, y, x } = self;
        for (first, count) in columns.panels() {
            let sums = products(simd, columns.panel(first, row, y.len()), y);
            x[first..].iter_mut().zip(&sums[..count]).for_each(|(x, &sum)| *x -= sum);
        }
    }
}

/// A panel, by its first rows.
#[inline(always)]
fn forward<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], count: usize, x: &mut [T]) {
    let (own, below) = x.split_at_mut(count);
    let (scale, mut solved) = (reciprocals(l, count), [T::narrow(0.0); PANEL]);
    solved[..count].copy_from_slice(own);
    for j in 0..count {
        solved[j] *= scale[j];
        for i in j + 1..count {
            solved[i] -= l[j][i] * solved[j];
        }
    }
    own.copy_from_slice(&solved[..count]);
    subtract(simd, each(l, |l| &l[count..]), solved, below);
}

#[inline(always)]
fn backward<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], count: usize, x: &mut [T]) {
    let (own, below) = x.split_at_mut(count);
    let sums = products(simd, each(l, |l| &l[count..]), below);
    let scale = reciprocals(l, count);
    for j in (0..count).rev() {
        let mut sum = own[j] - sums[j];
        for i in j + 1..count {
            sum -= l[j][i] * own[i];
        }
        own[j] = sum * scale[j];
    }
}

/// 1 / l_jj, by divisions that do not wait for each other.
#[inline(always)]
pub(super) fn reciprocals<T: Scalar>(l: [&[T]; PANEL], count: usize) -> [T; PANEL] {
    let mut scale = [T::narrow(0.0); PANEL];
    for j in 0..count {
        scale[j] = T::narrow(1.0) / l[j][j];
    }
    scale
}

/// y ← y − L x.
///
/// Vectors are counted from the end of y, as all panels of a front do: then they load what one
/// store wrote. The first vector overlaps the second, where both find the same numbers.
#[inline(always)]
fn subtract<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], x: [T; PANEL], y: &mut [T]) {
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

/// Lᵀ y.
///
/// The numbers that were found last come first in y. They are loaded last.
#[inline(always)]
fn products<T: Scalar, S: Simd>(simd: S, l: [&[T]; PANEL], y: &[T]) -> [T; PANEL] {
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
