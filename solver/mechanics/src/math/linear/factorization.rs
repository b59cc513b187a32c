//! Solution with a factored matrix.
//!
//! The dense part of A + U Σ Uᵀ enters by the formula of Woodbury,
//!
//! (A + U Σ Uᵀ)⁻¹ = A⁻¹ − Z (Σ⁻¹ + Uᵀ Z)⁻¹ Zᵀ,   Z = A⁻¹ U
//!
//! and its negative eigenvalues by those of A, with C = Σ⁻¹ + Uᵀ A⁻¹ U: both ways to eliminate from
//! [A U; Uᵀ −Σ⁻¹] have its inertia, so that there are neg(A) + pos(C) − pos(Σ) of them.
//!
//! Source: Golub and Van Loan, "Matrix Computations", sections 2.1.4 and 8.1.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Dyn, LU};

use super::cholesky::Factor;
use super::conjugate_gradients::{Gradients, Outcome, Stop, conjugate_gradients};
use super::direct::{Pivot, Precision};
use super::matrix::{Symmetric, Triangle, dot, norm};
use super::rows::{Row, SYSTEMS};
use super::several::{one_of, side_by_side, solve_several};

/// Relative residual of a solution that has come to rounding.
const SMALLEST_RESIDUAL: f64 = 1e-14;

/// Refinement steps of a solution, at most.
const REFINEMENTS: usize = 40;

/// Conjugate-gradient steps with the factor of another matrix that cost less than a factor of its own: the gripper is
/// factored at 260 GFLOP/s and solved at 33 GB/s, so that a factorisation takes as long as 15 steps. Its static solve
/// took 11.6, 10.3, 10.5 and 11.6 s of processor time with 12, 15, 18 and 24. Fewer steps for smaller bodies, by their
/// operations, left forces less balanced: Newton's method stagnated where blocks rest on each other.
const NEAR_STEPS: usize = 15;

/// Right sides that are solved one after the other.
const FEW_SIDES: usize = 3;

/// A matrix and its factor.
pub struct Factorization {
    pattern: Arc<Triangle>,
    matrix: Symmetric,
    factor: Factor,
    /// The precision of L Lᵀ; none of the factor of a matrix that is not positive definite.
    pub(super) positive: Option<Precision>,
    dense: Option<Dense>,
}

/// What the formula of Woodbury needs besides the factor of A.
struct Dense {
    /// A⁻¹ u_k
    columns: Vec<Vec<f64>>,
    /// Σ⁻¹ + Uᵀ A⁻¹ U
    capacitance: LU<f64, Dyn, Dyn>,
    /// Number of its positive eigenvalues.
    positive: usize,
}

impl Factorization {
    /// A matrix with the factor of its sparse part.
    pub(super) fn new(
        pattern: &Arc<Triangle>,
        matrix: Symmetric,
        factor: Factor,
        positive: Option<Precision>,
    ) -> Self {
        let dense = dense(&factor, &matrix.updates);
        Self { pattern: Arc::clone(pattern), matrix, factor, positive, dense }
    }

    /// The matrix.
    pub(super) fn matrix(&self) -> &Symmetric {
        &self.matrix
    }

    /// Whether the matrix has this pattern.
    pub(super) fn is_of(&self, pattern: &Arc<Triangle>) -> bool {
        Arc::ptr_eq(&self.pattern, pattern)
    }

    /// The matrix; the factor is gone.
    pub(super) fn into_matrix(self) -> Symmetric {
        self.matrix
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.pattern.size()
    }

    /// Whether it is that of a positive definite matrix.
    pub fn is_positive(&self) -> bool {
        self.positive.is_some()
    }

    /// The smallest pivot, if the matrix is positive definite.
    pub fn smallest_pivot(&self) -> Option<Pivot> {
        self.factor.smallest_pivot()
    }

    /// Number of negative eigenvalues of the matrix, its dense part included.
    pub fn negative_eigenvalues(&self) -> usize {
        let own = self.factor.negative_eigenvalues();
        let added = self.matrix.updates.iter().filter(|(scale, _)| *scale > 0.0).count();
        let positive = self.dense.as_ref().map_or(0, |dense| dense.positive);
        (own + positive).saturating_sub(added)
    }

    /// Solves A x = b in place, to rounding, and returns the relative residual
    /// ‖A x − b‖ / ‖b‖ that was reached.
    pub fn solve(&self, rhs: &mut [f64]) -> f64 {
        let b = rhs.to_vec();
        self.solve_to(rhs, SMALLEST_RESIDUAL);
        // conjugate gradients only update theirs
        norm(&self.residual(&b, rhs)) / norm(&b).max(f64::MIN_POSITIVE)
    }

    /// Solves A x = b in place to a relative residual, or to rounding where that is more, and
    /// returns the one that was reached.
    pub fn solve_to(&self, rhs: &mut [f64], tolerance: f64) -> f64 {
        let (x, residual) = if self.is_positive() {
            let stop = Stop { tolerance, steps: REFINEMENTS, near: false };
            let Gradients { x, residual, .. } = self.gradients(&self.matrix, rhs, &stop);
            (x, residual)
        } else {
            self.refine(rhs, tolerance)
        };
        rhs.copy_from_slice(&x);
        residual
    }

    /// Solves A x = b in place for several b to a relative residual, as [`Self::solve_to`] does for one. What is read of
    /// the matrix and the factor serves [`SYSTEMS`] of them.
    pub fn solve_all_to(&self, sides: &mut [Vec<f64>], tolerance: f64) {
        if !self.is_positive() || self.dense.is_some() || sides.len() < FEW_SIDES {
            sides.iter_mut().for_each(|side| _ = self.solve_to(side, tolerance));
            return;
        }
        let multiply = |x: &[Row<f64>]| self.pattern.multiply_several(&self.matrix, x);
        let precondition = |x: &[Row<f64>]| {
            let mut x = x.to_vec();
            self.factor.apply_inverse_all(&mut x);
            x
        };
        for sides in sides.chunks_mut(SYSTEMS) {
            let b = side_by_side(sides);
            let x = solve_several(multiply, precondition, b, (tolerance, REFINEMENTS));
            sides.iter_mut().enumerate().for_each(|(k, side)| *side = one_of(&x, k));
        }
    }

    /// Solves A x = b, to ‖A x − b‖ ≤ tolerance ‖b‖, by conjugate gradients with a factor some
    /// of whose pivots were replaced. They meet a direction of negative curvature after a few
    /// steps if A is not positive definite.
    pub fn solve_modified(&self, b: &[f64], tolerance: f64) -> Outcome {
        let stop = Stop { tolerance, steps: REFINEMENTS, near: false };
        self.gradients(&self.matrix, b, &stop).outcome(tolerance)
    }

    /// Solves for another matrix by conjugate gradients, preconditioned with this factor, to
    /// ‖A x − b‖ ≤ tolerance ‖b‖. [`Outcome::Inaccurate`] where a factorisation is likely to be
    /// cheaper, or this one is not that of a positive definite matrix.
    pub fn solve_near(&self, matrix: &Symmetric, b: &[f64], tolerance: f64) -> Outcome {
        if !self.is_positive() {
            return Outcome::Inaccurate;
        }
        let stop = Stop { tolerance, steps: NEAR_STEPS, near: true };
        self.gradients(matrix, b, &stop).outcome(tolerance)
    }

    /// Conjugate gradients preconditioned with the factor.
    fn gradients(&self, matrix: &Symmetric, b: &[f64], stop: &Stop) -> Gradients {
        let multiply = |x: &[f64]| self.pattern.multiply(matrix, x);
        conjugate_gradients(multiply, |x| self.inverse_times(x), b, stop)
    }

    /// Iterative refinement; the best x and its relative residual.
    fn refine(&self, b: &[f64], tolerance: f64) -> (Vec<f64>, f64) {
        let size = norm(b).max(f64::MIN_POSITIVE);
        let mut x = self.inverse_times(b);
        let mut best: Option<(Vec<f64>, f64)> = None;
        for _ in 0..REFINEMENTS {
            let r = self.residual(b, &x);
            let residual = norm(&r) / size;
            let better = best.as_ref().is_none_or(|(_, least)| residual < *least);
            if !better {
                break;
            }
            best = Some((x.clone(), residual));
            if residual <= tolerance {
                break;
            }
            x.iter_mut().zip(self.inverse_times(&r)).for_each(|(x, d)| *x += d);
        }
        best.unwrap_or((x, f64::INFINITY))
    }

    /// b − A x.
    pub fn residual(&self, b: &[f64], x: &[f64]) -> Vec<f64> {
        let ax = self.pattern.multiply(&self.matrix, x);
        b.iter().zip(&ax).map(|(b, a)| b - a).collect()
    }

    /// A⁻¹ x by the factor, without refinement.
    pub(super) fn inverse_times(&self, x: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        self.factor.apply_inverse(&mut x);
        let Some(Dense { columns, capacitance, .. }) = &self.dense else { return x };
        let updates = &self.matrix.updates;
        let projected =
            DVector::from_iterator(updates.len(), updates.iter().map(|(_, u)| dot(u, &x)));
        // singular only if the whole matrix is; the result is then NaN
        let weights = capacitance.solve(&projected).unwrap_or_else(|| projected.map(|_| f64::NAN));
        for (z, weight) in columns.iter().zip(weights.iter()) {
            x.iter_mut().zip(z).for_each(|(x, z)| *x -= weight * z);
        }
        x
    }
}

fn dense(factor: &Factor, updates: &[(f64, Vec<f64>)]) -> Option<Dense> {
    if updates.is_empty() {
        return None;
    }
    let mut columns: Vec<Vec<f64>> = updates.iter().map(|(_, u)| u.clone()).collect();
    columns.iter_mut().for_each(|z| factor.apply_inverse(z));
    let matrix = DMatrix::from_fn(updates.len(), updates.len(), |i, j| {
        let diagonal = if i == j { 1.0 / updates[i].0 } else { 0.0 };
        diagonal + dot(&updates[i].1, &columns[j])
    });
    let eigenvalues = matrix.clone().symmetric_eigenvalues();
    let positive = eigenvalues.iter().filter(|value| **value > 0.0).count();
    Some(Dense { columns, capacitance: matrix.lu(), positive })
}
