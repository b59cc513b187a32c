//! The one parallel loop: results do not depend on the number of threads.

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
    let chunks = len.div_ceil(CHUNK);
    let range = |c: usize| c * CHUNK..((c + 1) * CHUNK).min(len);
    for first in (0..chunks).step_by(WAVE) {
        let wave = first..(first + WAVE).min(chunks);
        let results: Vec<T> = wave.clone().into_par_iter().map(|c| map(range(c))).collect();
        for (c, result) in wave.zip(results) {
            merge(range(c), result);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_the_same_for_any_thread_count() {
        let sum = || {
            let mut total = 0.0;
            map_merge(
                10_007,
                |range| range.map(|i| (i as f64).sin()).sum::<f64>(),
                |_, part| total += part,
            );
            total
        };
        let results: Vec<u64> = [1, 2, 7]
            .into_iter()
            .map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                pool.expect("a thread pool").install(sum).to_bits()
            })
            .collect();
        assert!(results.windows(2).all(|w| w[0] == w[1]));
    }
}
