//! Substitution with the columns of one front, L₁₁ and L₂₁, which form a trapezoid. Those of
//! the large fronts at the top of the elimination tree are read by all threads, in blocks of
//! columns; the blocks do not depend on the number of threads.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::scalar::Scalar;

/// Entries of a front that are worth several threads.
const LARGE: usize = 1 << 18;
/// Columns of a large front that are solved before their rows are gone through.
const BLOCK: usize = 128;
/// Rows of a block that are one task.
const ROWS: usize = 512;
/// Columns of a block that are one task.
const COLUMNS: usize = 8;

/// x ← L₁₁⁻¹ x and y ← y − L₂₁ x, in place of x and y one after the other.
pub fn forward<T: Scalar>(front: MatRef<'_, T>, xy: &mut [T]) {
    let (height, width) = front.shape();
    let block = if height * width < LARGE { width } else { BLOCK };
    for first in (0..width).step_by(block) {
        let end = (first + block).min(width);
        let columns = front.subcols(first, end - first);
        let (known, rest) = xy[first..].split_at_mut(end - first);
        let top = columns.subrows(first, end - first);
        solve_lower_triangular_in_place(top, column(known), Par::Seq);
        let known = MatRef::from_column_major_slice(known, end - first, 1);
        let subtract = |row: usize, rest: &mut [T]| {
            let part = columns.subrows(end + row, rest.len());
            matmul(column(rest), Accum::Add, part, known, T::narrow(-1.0), Par::Seq);
        };
        if block == width {
            if !rest.is_empty() {
                subtract(0, rest);
            }
        } else {
            let parts = rest.par_chunks_mut(ROWS).enumerate();
            parts.for_each(|(i, rest)| subtract(i * ROWS, rest));
        }
    }
}

/// x ← L₁₁⁻ᵀ (x − L₂₁ᵀ y), in place of x, after which y follows.
pub fn backward<T: Scalar>(front: MatRef<'_, T>, xy: &mut [T]) {
    let (height, width) = front.shape();
    let block = if height * width < LARGE { width } else { BLOCK };
    for first in (0..width).step_by(block).rev() {
        let end = (first + block).min(width);
        let columns = front.subcols(first, end - first);
        let (sought, known) = xy[first..].split_at_mut(end - first);
        let below = columns.subrows(end, height - end);
        let subtract = |first: usize, sought: &mut [T]| {
            let part = below.subcols(first, sought.len()).transpose();
            let known = MatRef::from_column_major_slice(known, height - end, 1);
            matmul(column(sought), Accum::Add, part, known, T::narrow(-1.0), Par::Seq);
        };
        if block == width {
            if !known.is_empty() {
                subtract(0, sought);
            }
        } else {
            let parts = sought.par_chunks_mut(COLUMNS).enumerate();
            parts.for_each(|(i, sought)| subtract(i * COLUMNS, sought));
        }
        let top = columns.subrows(first, end - first);
        solve_upper_triangular_in_place(top.transpose(), column(sought), Par::Seq);
    }
}

fn column<T>(values: &mut [T]) -> MatMut<'_, T> {
    let len = values.len();
    MatMut::from_column_major_slice_mut(values, len, 1)
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
        let front = MatRef::from_column_major_slice(&values, height, width);
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
