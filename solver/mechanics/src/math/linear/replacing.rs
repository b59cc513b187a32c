//! Cholesky factorisation of a small dense matrix whose pivots need not be positive.
//!
//! L Lᵀ = A + E with E diagonal, and zero where the pivot is positive: a modified Cholesky
//! factorisation. Source: Nocedal and Wright, "Numerical Optimization", section 3.4.

use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, MatMut, Par};

use super::scalar::Scalar;

/// Columns that are eliminated one by one before the rest is updated at once.
const PANEL: usize = 48;

/// Replaces the lower triangle of A by L and returns the number of pivots that were
/// replaced. A pivot p that is not larger than rounding makes of `scale`, a typical
/// diagonal entry, becomes the larger of `scale` and |p|.
pub fn cholesky<T: Scalar>(mut a: MatMut<T>, scale: f64, par: Par) -> usize {
    let n = a.nrows();
    let mut replaced = 0;
    for first in (0..n).step_by(PANEL) {
        let end = (first + PANEL).min(n);
        let remaining = a.as_mut().submatrix_mut(first, first, n - first, n - first);
        let (mut block, _, mut below, mut rest) = remaining.split_at_mut(end - first, end - first);
        replaced += eliminate(block.as_mut(), scale);
        solve_lower_triangular_in_place(block.as_ref(), below.as_mut().transpose_mut(), par);
        triangular_matmul(
            rest.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            below.as_ref(),
            BlockStructure::Rectangular,
            below.as_ref().transpose(),
            BlockStructure::Rectangular,
            T::narrow(-1.0),
            par,
        );
    }
    replaced
}

/// Factors one panel column by column, as [`cholesky`] does the matrix.
fn eliminate<T: Scalar>(mut a: MatMut<T>, scale: f64) -> usize {
    let n = a.nrows();
    let mut replaced = 0;
    for j in 0..n {
        let mut pivot = a[(j, j)].widen();
        if pivot.is_nan() || pivot <= T::PIVOT_ROUNDING * scale {
            pivot = scale.max(pivot.abs());
            replaced += 1;
        }
        let l = T::narrow(pivot.sqrt());
        a[(j, j)] = l;
        let inverse = T::narrow(1.0 / pivot.sqrt());
        for i in j + 1..n {
            let scaled = a[(i, j)] * inverse;
            a[(i, j)] = scaled;
        }
        for k in j + 1..n {
            let factor = a[(k, j)];
            for i in k..n {
                let product = a[(i, j)] * factor;
                a[(i, k)] -= product;
            }
        }
    }
    replaced
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use faer::Mat;

    /// L Lᵀ − A is zero but for as many diagonal entries as A has negative eigenvalues.
    #[test]
    fn only_bad_pivots_change() {
        let n = 130;
        let mut random = Random::new(5);
        let mut b = Mat::<f64>::zeros(n, n);
        for j in 0..n {
            for (i, v) in random.numbers(n).into_iter().enumerate() {
                b[(i, j)] = v;
            }
        }
        let mut a = &b * b.transpose();
        for i in 0..n {
            a[(i, i)] += 1.0;
        }
        // rows and columns 7 and 90 with the sign of their diagonal entry turned
        for i in [7, 90] {
            a[(i, i)] = -a[(i, i)];
        }
        let scale = (0..n).map(|i| a[(i, i)].abs()).sum::<f64>() / n as f64;
        let mut l = a.clone();
        assert_eq!(cholesky(l.as_mut(), scale, Par::Seq), 2);
        for j in 0..n {
            for i in 0..j {
                l[(i, j)] = 0.0;
            }
        }
        let e = &l * l.transpose() - &a;
        for j in 0..n {
            for i in 0..n {
                let changed = i == j && [7, 90].contains(&i);
                assert_eq!(e[(i, j)].abs() > 1e-9 * scale, changed, "{i} {j}: {}", e[(i, j)]);
                assert!(!changed || e[(i, j)] >= scale);
            }
        }
    }
}
