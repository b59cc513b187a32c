//! The one parallel loop: results do not depend on the number of threads.

use std::sync::Mutex;

use rayon::prelude::*;

/// Items handed to one task at a time. A constant, so that reductions over
/// chunks give the same bits for any number of threads.
const CHUNK: usize = 256;

/// Chunks computed before their results are merged; bounds the memory that
/// waits for the serial merge.
const WAVE: usize = 16;

/// Calls `map` on consecutive index ranges of `0..len` in parallel and `merge`
/// on the results, serially and in the order of the ranges.
pub fn map_merge<T: Send>(
    len: usize,
    map: impl Fn(std::ops::Range<usize>) -> T + Sync,
    mut merge: impl FnMut(std::ops::Range<usize>, T),
) {
    map_merge_waves(len, map, |range, results| {
        let ranges = range.clone().step_by(CHUNK).map(|i| i..(i + CHUNK).min(range.end));
        ranges.zip(results).for_each(|(range, result)| merge(range, result));
    });
}

/// Calls `map` on each item in parallel, and `merge` on each with its result, serially and in their order.
pub fn map_each<I: Sync, T: Send>(
    items: &[I],
    map: impl Fn(&I) -> T + Sync,
    mut merge: impl FnMut(&I, T),
) {
    map_merge(
        items.len(),
        |range| items[range].iter().map(&map).collect::<Vec<T>>(),
        |range, parts| items[range].iter().zip(parts).for_each(|(item, part)| merge(item, part)),
    );
}

/// As [`map_merge`], but `merge` gets the results of many consecutive ranges at
/// once, to go about them in parallel.
pub fn map_merge_waves<T: Send>(
    len: usize,
    map: impl Fn(std::ops::Range<usize>) -> T + Sync,
    mut merge: impl FnMut(std::ops::Range<usize>, Vec<T>),
) {
    for first in (0..len).step_by(WAVE * CHUNK) {
        let wave = first..(first + WAVE * CHUNK).min(len);
        let results: Vec<Mutex<Option<T>>> =
            wave.clone().step_by(CHUNK).map(|_| Mutex::default()).collect();
        each(results.len(), &|chunk| {
            let i = first + chunk * CHUNK;
            let result = map(i..(i + CHUNK).min(wave.end));
            *results[chunk].lock().expect(POISONED) = Some(result);
        });
        let taken = |result: Mutex<Option<T>>| result.into_inner().expect(POISONED);
        merge(wave, results.into_iter().filter_map(taken).collect());
    }
}

/// Never: a panic of `map` ends the loop before.
const POISONED: &str = "a chunk whose work ended";

/// Calls `work` on each of `0..count` in parallel. Not generic, so that rayon's loop is compiled once for all callers.
fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}

/// Calls `fill` on consecutive index ranges of `0..len` in parallel, with the part of a
/// vector that belongs to the range, `each` values an index, and returns the vector.
pub fn fill<T: Clone + Send + Sync>(
    len: usize,
    each: usize,
    zero: T,
    fill: impl Fn(std::ops::Range<usize>, &mut [T]) + Sync,
) -> Vec<T> {
    let mut values = Vec::new();
    rayon::iter::repeat_n(zero, len * each).with_min_len(CHUNK).collect_into_vec(&mut values);
    values.par_chunks_mut(CHUNK * each).enumerate().for_each(|(i, values)| {
        let first = i * CHUNK;
        fill(first..first + values.len() / each, values);
    });
    values
}
