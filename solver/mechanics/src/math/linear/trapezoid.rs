//! Substitution with the columns of one front, L₁₁ and L₂₁, which form a trapezoid. Those of
//! the large fronts at the top of the elimination tree are read by all threads, in blocks of
//! columns; the blocks do not depend on the number of threads.

use rayon::prelude::*;

use super::columns::{Columns, Work};
use super::scalar::Scalar;
use super::unknown::Unknown;

/// Entries of a front that are worth several threads.
const LARGE: usize = 1 << 18;
/// Columns of a large front that are solved before their rows are gone through.
const BLOCK: usize = 128;
/// Rows of a block that are one task.
const ROWS: usize = 512;
/// Columns of a block that are one task.
const COLUMNS: usize = 8;

/// x ← L₁₁⁻¹ x and y ← y − L₂₁ x, in place of x and y one after the other.
pub fn forward<T: Scalar, X: Unknown<T>>(front: Columns<'_, T>, xy: &mut [X]) {
    let width = front.count();
    if xy.len() * width < LARGE {
        return front.work(0, Work::Forward(xy));
    }
    for first in (0..width).step_by(BLOCK) {
        let end = (first + BLOCK).min(width);
        let columns = front.part(first, end - first);
        let (known, rest) = xy[first..].split_at_mut(end - first);
        columns.work(first, Work::Forward(known));
        let parts = rest.par_chunks_mut(ROWS).enumerate();
        parts.for_each(|(i, y)| columns.work(end + i * ROWS, Work::Subtract { x: known, y }));
    }
}

/// x ← L₁₁⁻ᵀ (x − L₂₁ᵀ y), in place of x, after which y follows.
pub fn backward<T: Scalar, X: Unknown<T>>(front: Columns<'_, T>, xy: &mut [X]) {
    let width = front.count();
    if xy.len() * width < LARGE {
        return front.work(0, Work::Backward(xy));
    }
    for first in (0..width).step_by(BLOCK).rev() {
        let end = (first + BLOCK).min(width);
        let columns = front.part(first, end - first);
        let (sought, known) = xy[first..].split_at_mut(end - first);
        let parts = sought.par_chunks_mut(COLUMNS).enumerate();
        parts.for_each(|(i, x)| {
            let part = columns.part(i * COLUMNS, x.len());
            part.work(end, Work::SubtractTransposed { y: known, x });
        });
        columns.work(first, Work::Backward(sought));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A front of 700 rows and 500 columns, in blocks and tasks, against both definitions.
    #[test]
    fn large_fronts_are_solved_by_blocks() {
        let (height, width) = (700, 500);
        let entry = |i: usize, j: usize| {
            if i == j { 2.0 } else { ((7 * i + 3 * j) % 11) as f64 / 1e3 }
        };
        let values: Vec<f64> = (0..width)
            .flat_map(|j| (0..height).map(move |i| if i < j { f64::NAN } else { entry(i, j) }))
            .collect();
        let front = Columns::new(&values, height);
        let start: Vec<f64> = (0..height).map(|i| (i as f64).sin()).collect();
        let mut down = start.clone();
        forward(front, &mut down);
        let mut up = start.clone();
        backward(front, &mut up);
        for i in 0..height {
            let known: f64 = (0..i.min(width)).map(|j| entry(i, j) * down[j]).sum();
            let own = if i < width { 2.0 * down[i] } else { down[i] };
            assert!((own + known - start[i]).abs() < 1e-12);
        }
        for j in 0..width {
            let known: f64 = (j + 1..height).map(|i| entry(i, j) * up[i]).sum();
            assert!((2.0 * up[j] + known - start[j]).abs() < 1e-12);
        }
    }
}
