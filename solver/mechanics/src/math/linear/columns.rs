//! Products and substitutions with columns of a front, by the widest vectors of this machine.
//!
//! All of them read each entry once and do little with it, so that memory is to limit them: the
//! columns go by panels of four, whose entries stream side by side while the vector they act on
//! stays in the cache. More streams than that, or fewer, are slower here.

use pulp::{Simd, WithSimd};

use super::scalar::Scalar;
use super::unknown::{PANEL, Unknown, each};
use crate::math::lanes::widest;

/// Columns of one height, one after the other.
#[derive(Clone, Copy)]
pub struct Columns<'a, T> {
    values: &'a [T],
    height: usize,
}

/// What is done with the rows of columns, panel by panel, to one system or to several.
pub enum Work<'a, X> {
    /// x₁ ← L₁₁⁻¹ x₁ and x₂ ← x₂ − L₂₁ x₁, with x₁, one unknown for each column, and x₂ below.
    Forward(&'a mut [X]),
    /// x₁ ← L₁₁⁻ᵀ (x₁ − L₂₁ᵀ x₂).
    Backward(&'a mut [X]),
    /// y ← y − L x.
    Subtract { x: &'a [X], y: &'a mut [X] },
    /// x ← x − Lᵀ y.
    SubtractTransposed { y: &'a [X], x: &'a mut [X] },
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

    /// Does work with the rows from `row` on.
    pub fn work<X: Unknown<T>>(self, row: usize, work: Work<'_, X>) {
        widest(Substitute { columns: self, row, work });
    }

    /// Panels of columns by the first column of each and their number.
    #[inline(always)]
    fn panels(self) -> impl DoubleEndedIterator<Item = (usize, usize)> {
        let count = self.count();
        (0..count.div_ceil(PANEL)).map(move |p| (p * PANEL, PANEL.min(count - p * PANEL)))
    }

    /// A panel from a row on, cut to a length. Where it has fewer columns, the last one fills it up.
    #[inline(always)]
    fn panel(self, first: usize, row: usize, len: usize) -> [&'a [T]; PANEL] {
        let last = self.count() - 1;
        let column = |j| &self.values[last.min(first + j) * self.height + row..][..len];
        [column(0), column(1), column(2), column(3)]
    }
}

struct Substitute<'a, T, X> {
    columns: Columns<'a, T>,
    row: usize,
    work: Work<'a, X>,
}

impl<T: Scalar, X: Unknown<T>> WithSimd for Substitute<'_, T, X> {
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
                    let mut by = [X::zero(); PANEL];
                    by[..count].copy_from_slice(&x[first..][..count]);
                    X::subtract(simd, columns.panel(first, row, y.len()), by, y);
                }
            }
            Work::SubtractTransposed { y, x } => {
                for (first, count) in columns.panels() {
                    let sums = X::products(simd, columns.panel(first, row, y.len()), y);
                    let pairs = x[first..].iter_mut().zip(&sums[..count]);
                    pairs.for_each(|(x, sum)| *x = x.plus(T::narrow(-1.0), *sum));
                }
            }
        }
    }
}

/// A panel, by its first rows.
#[inline(always)]
fn forward<T: Scalar, X: Unknown<T>, S: Simd>(
    simd: S,
    l: [&[T]; PANEL],
    count: usize,
    x: &mut [X],
) {
    let (own, below) = x.split_at_mut(count);
    let (scale, mut solved) = (reciprocals(l, count), [X::zero(); PANEL]);
    for j in 0..count {
        let mut unknown = own[j];
        for i in 0..j {
            unknown = unknown.plus(-l[i][j], solved[i]);
        }
        solved[j] = unknown.times(scale[j]);
        own[j] = solved[j];
    }
    X::subtract(simd, each(l, |l| &l[count..]), solved, below);
}

#[inline(always)]
fn backward<T: Scalar, X: Unknown<T>, S: Simd>(
    simd: S,
    l: [&[T]; PANEL],
    count: usize,
    x: &mut [X],
) {
    let (own, below) = x.split_at_mut(count);
    let sums = X::products(simd, each(l, |l| &l[count..]), below);
    let scale = reciprocals(l, count);
    for j in (0..count).rev() {
        let mut unknown = own[j].plus(T::narrow(-1.0), sums[j]);
        for i in j + 1..count {
            unknown = unknown.plus(-l[j][i], own[i]);
        }
        own[j] = unknown.times(scale[j]);
    }
}

/// 1 / l_jj, by divisions that do not wait for each other.
#[inline(always)]
fn reciprocals<T: Scalar>(l: [&[T]; PANEL], count: usize) -> [T; PANEL] {
    let mut scale = [T::narrow(0.0); PANEL];
    for j in 0..count {
        scale[j] = T::narrow(1.0) / l[j][j];
    }
    scale
}
