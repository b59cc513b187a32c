//! The update of a supernode enters the front of its parent.

use std::ops::Range;

use faer::Par;
use rayon::prelude::*;

use super::scalar::{Scalar, narrow};

/// Adds some columns of an update, a square whose rows and columns have the given places in
/// the front of its parent, to columns of a height that begin at the place `skip`.
pub fn extend_add<T: Scalar>(
    places: &[u32],
    update: &[T],
    target: &mut [T],
    height: usize,
    columns: Range<usize>,
    skip: usize,
    par: Par,
) {
    let n = places.len();
    let runs = runs(places);
    let add = |column: usize, target: &mut [T]| {
        let source = &update[column * n..(column + 1) * n];
        let after = runs.partition_point(|run| run.0.end <= column);
        for (from, to) in &runs[after..] {
            let start = from.start.max(column);
            let to = to + (start - from.start) - skip;
            let target = &mut target[to..to + (from.end - start)];
            for (t, v) in target.iter_mut().zip(&source[start..from.end]) {
                *t += *v;
            }
        }
    };
    if matches!(par, Par::Seq) {
        for c in columns {
            let place = places[c] as usize - skip;
            add(c, &mut target[place * height..(place + 1) * height]);
        }
    } else {
        target.par_chunks_mut(height).enumerate().for_each(|(place, target)| {
            if let Ok(c) = places[columns.clone()].binary_search(&narrow(place + skip)) {
                add(columns.start + c, target);
            }
        });
    }
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
