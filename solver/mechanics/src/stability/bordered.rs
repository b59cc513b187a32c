//! Bordered linear systems: a symmetric matrix A, that of the last factorisation, with a few more rows and columns,
//!
//! A x + B y = f,   C x + D y = g
//!
//! by block elimination with S = D − C A⁻¹ B, and refinement of the whole system. That keeps it accurate where
//! A itself is nearly singular and the bordered matrix is not, as at a limit point.
//!
//! Source: Govaerts 2000, "Numerical Methods for Bifurcations of Dynamical Equilibria", chapter 3.

use nalgebra::linalg::LU;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::math::linear::{Factorization, dot, norm};

/// Refinements of a solution, at most.
const REFINEMENTS: usize = 6;
/// Relative residual that needs no refinement.
const ENOUGH: f64 = 1e-13;

/// What is around A, with A⁻¹ B and S.
pub struct Bordered {
    columns: Vec<Vec<f64>>,
    rows: Vec<Vec<f64>>,
    corner: DMatrix<f64>,
    solved: Vec<Vec<f64>>,
    schur: DMatrix<f64>,
    factored: LU<f64, Dyn, Dyn>,
}

impl Bordered {
    /// Borders the matrix of a factorisation by the columns B, the rows C and the corner D.
    pub fn new(
        factor: &Factorization,
        columns: Vec<Vec<f64>>,
        rows: Vec<Vec<f64>>,
        corner: DMatrix<f64>,
    ) -> Self {
        let mut solved = columns.clone();
        for z in &mut solved {
            factor.solve(z);
        }
        let count = rows.len();
        let schur =
            DMatrix::from_fn(count, count, |i, j| corner[(i, j)] - dot(&rows[i], &solved[j]));
        let factored = schur.clone().lu();
        Self { columns, rows, corner, solved, schur, factored }
    }

    /// Number of rows around A.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Number of negative eigenvalues of S, where the bordered matrix is symmetric.
    pub fn negative_eigenvalues(&self) -> usize {
        if self.rows.is_empty() {
            return 0;
        }
        let eigenvalues = self.schur.clone().symmetric_eigenvalues();
        eigenvalues.iter().filter(|value| **value < 0.0).count()
    }

    /// The solution x and y for f and g; none where the bordered matrix is singular.
    pub fn solve(
        &self,
        factor: &Factorization,
        upper: &[f64],
        lower: &[f64],
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let (mut x, mut y) = self.once(factor, upper, lower)?;
        let mut best = (x.clone(), y.clone(), f64::INFINITY);
        for _ in 0..REFINEMENTS {
            let (above, below, error) = self.residual(factor, &x, &y, upper, lower);
            if error.is_nan() || error >= best.2 {
                break;
            }
            best = (x.clone(), y.clone(), error);
            if error <= ENOUGH {
                break;
            }
            let (dx, dy) = self.once(factor, &above, &below)?;
            x.iter_mut().zip(&dx).for_each(|(x, d)| *x += d);
            y.iter_mut().zip(&dy).for_each(|(y, d)| *y += d);
        }
        let (x, y, error) = best;
        error.is_finite().then_some((x, y))
    }

    /// A solution by block elimination alone.
    fn once(
        &self,
        factor: &Factorization,
        upper: &[f64],
        lower: &[f64],
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut x = upper.to_vec();
        if norm(upper) > 0.0 {
            factor.solve(&mut x);
        }
        if lower.is_empty() {
            return Some((x, Vec::new()));
        }
        let side = DVector::from_fn(lower.len(), |i, _| lower[i] - dot(&self.rows[i], &x));
        let y = self.factored.solve(&side)?;
        for (z, weight) in self.solved.iter().zip(y.iter()) {
            x.iter_mut().zip(z).for_each(|(x, z)| *x -= weight * z);
        }
        Some((x, y.iter().copied().collect()))
    }

    /// What a solution leaves of f and g, and how large that is beside their terms.
    fn residual(
        &self,
        factor: &Factorization,
        x: &[f64],
        y: &[f64],
        upper: &[f64],
        lower: &[f64],
    ) -> (Vec<f64>, Vec<f64>, f64) {
        let mut above = factor.residual(upper, x);
        let mut size = norm(upper);
        for (column, weight) in self.columns.iter().zip(y) {
            above.iter_mut().zip(column).for_each(|(r, c)| *r -= weight * c);
            size = size.max(weight.abs() * norm(column));
        }
        let mut error = norm(&above) / size.max(f64::MIN_POSITIVE);
        let mut below = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            let corner = (0..y.len()).map(|j| self.corner[(i, j)] * y[j]);
            let terms: Vec<f64> = corner.chain([dot(row, x)]).collect();
            let size = terms.iter().fold(lower[i].abs(), |m, t| m.max(t.abs()));
            let left = lower[i] - terms.iter().sum::<f64>();
            error = error.max(left.abs() / size.max(f64::MIN_POSITIVE));
            below.push(left);
        }
        (above, below, error)
    }
}
