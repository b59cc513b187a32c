//! The update of a supernode enters the front of its parent.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::scalar::Scalar;
use crate::math::lanes::widest;

/// Adds some columns of an update, a square whose rows and columns have the given places in the
/// front of its parent, to columns of a height, whose first entry has the place `corner`.
pub fn extend_add<T: Scalar>(
    places: &[u32],
    update: &[T],
    columns: Range<usize>,
    target: &mut [T],
    height: usize,
    [row, first]: [usize; 2],
) {
    let runs = runs(places);
    for column in columns {
        let source = &update[column * places.len()..(column + 1) * places.len()];
        let place = places[column] as usize - first;
        let target = &mut target[place * height..(place + 1) * height];
        widest(AddColumn { column, source, runs: &runs, skip: row, target });
    }
}

/// Adds one column of an update from its diagonal on.
struct AddColumn<'a, T> {
    column: usize,
    source: &'a [T],
    runs: &'a [(Range<usize>, usize)],
    skip: usize,
    target: &'a mut [T],
}

impl<T: Scalar> WithSimd for AddColumn<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { column, source, runs, skip, target } = self;
        let after = runs.partition_point(|run| run.0.end <= column);
        for (from, to) in &runs[after..] {
            let start = from.start.max(column);
            let to = to + (start - from.start) - skip;
            let source = &source[start..from.end];
            add(simd, source, &mut target[to..][..source.len()]);
        }
    }
}

/// y ← y + x. Runs are short: what fills no vector goes by fours.
#[inline(always)]
fn add<T: Scalar, S: Simd>(simd: S, x: &[T], y: &mut [T]) {
    let ctx = T::simd_ctx(simd);
    let whole = T::vectors::<S>(x);
    for (y, x) in T::vectors_mut::<S>(y).iter_mut().zip(whole) {
        *y = T::simd_add(&ctx, *y, *x);
    }
    let done = size_of_val(whole) / size_of::<T>();
    let (x, x_rest) = x[done..].as_chunks::<4>();
    let (y, y_rest) = y[done..].as_chunks_mut::<4>();
    for (y, x) in y.iter_mut().zip(x) {
        (0..4).for_each(|k| y[k] += x[k]);
    }
    y_rest.iter_mut().zip(x_rest).for_each(|(y, &x)| *y += x);
}

/// Maximal ranges of a sequence that are consecutive numbers, with the first
/// number of each.
fn runs(places: &[u32]) -> Vec<(Range<usize>, usize)> {
    let mut runs: Vec<(Range<usize>, usize)> = Vec::new();
    for (i, place) in places.iter().map(|&p| p as usize).enumerate() {
        match runs.last_mut() {
            Some((range, first)) if place == *first + range.len() => range.end = i + 1,
            _ => runs.push((i..i + 1, place)),
        }
    }
    runs
}
