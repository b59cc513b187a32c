//! What factors matrices: the interface of a direct solver.

use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::matrix::Triangle;
use super::rows::{Row, SYSTEMS};
use super::several::one_of;
use crate::math::pool::Pool;

/// Precision of a factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Half the memory and half the time; solutions take a few more steps of
    /// refinement, the more the worse the matrix is conditioned.
    Single,
    /// A solution is accurate without refinement.
    Double,
}

/// What to do with pivots that are not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadPivots {
    /// The matrix is not positive definite: no factor.
    Refuse,
    /// A typical diagonal entry of A takes the place of a few of them; of more the matrix is
    /// refused.
    ReplaceFew,
}

/// A pivot L_ii² of a factorisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pivot {
    /// The value.
    pub value: f64,
    /// The largest one.
    pub largest: f64,
    /// The unknown that it eliminated.
    pub unknown: usize,
}

/// What a factorisation takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Stored entries of the factor.
    pub entries: usize,
    /// Floating-point operations.
    pub flops: f64,
    /// Part of `flops` in fronts that must follow one another.
    pub chain_flops: f64,
    /// Memory in single precision, at most [B].
    pub bytes: usize,
}

/// The sparsity pattern of the matrices of a [`DirectSolver`], and its order of elimination.
pub struct Structure<'a> {
    /// The lower triangle.
    pub pattern: &'a Arc<Triangle>,
    /// Unknowns that are coupled with each other and with the same others, group by group in the
    /// order of elimination, up to changes that leave the fill alone.
    pub groups: &'a [Range<usize>],
    /// Memory that solvers of earlier patterns have left.
    pub memory: &'a Memory,
}

/// Buffers in single precision that factorisations leave to others: those of the updates, and those of factors.
#[derive(Clone, Default)]
pub struct Memory {
    pub(super) updates: Arc<Pool<f32>>,
    factors: Arc<Mutex<Vec<Vec<f32>>>>,
}

impl Memory {
    /// The buffer of an earlier factor, if one of this length is left.
    pub(super) fn take_factor(&self, len: usize) -> Option<Vec<f32>> {
        let taken = self.factors().pop()?;
        if taken.len() != len {
            // all are of another pattern
            self.drop_factors();
            return None;
        }
        Some(taken)
    }

    /// Leaves the buffer of a factor to the next.
    pub(super) fn leave_factor(&self, values: Vec<f32>) {
        self.factors().push(values);
    }

    /// Gives the buffers of factors back to the system.
    pub(super) fn drop_factors(&self) {
        self.factors().clear();
    }

    fn factors(&self) -> MutexGuard<'_, Vec<Vec<f32>>> {
        self.factors.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Makes a direct solver.
pub type MakeDirectSolver = fn(&Structure) -> Box<dyn DirectSolver>;

/// Factors the sparse part of symmetric matrices of one sparsity pattern.
pub trait DirectSolver: Send + Sync {
    /// What a factorisation takes.
    fn cost(&self) -> Cost;

    /// L Lᵀ = A, or A + E with E at a few replaced pivots, and the number of these. `lower` are
    /// the values of the lower triangle.
    fn factor_positive(
        &self,
        lower: &[f64],
        precision: Precision,
        bad_pivots: BadPivots,
    ) -> Result<(Box<dyn Factor>, usize), usize>;

    /// L B Lᵀ = A for any symmetric A.
    fn factor_indefinite(&self, lower: &[f64]) -> Box<dyn Factor>;
}

/// A factored matrix.
pub trait Factor: Send + Sync {
    /// x ← A⁻¹ x, with the precision of the factor.
    fn apply_inverse(&self, x: &mut [f64]);

    /// X ← A⁻¹ X of several systems side by side.
    fn apply_inverse_all(&self, x: &mut [Row<f64>]) {
        for k in 0..SYSTEMS {
            let mut one = one_of(x, k);
            self.apply_inverse(&mut one);
            x.iter_mut().zip(one).for_each(|(row, x)| row.0[k] = x);
        }
    }

    /// The smallest pivot of L Lᵀ; none of other factors.
    fn smallest_pivot(&self) -> Option<Pivot> {
        None
    }

    /// Number of negative eigenvalues of the matrix, by the law of inertia; 0 of L Lᵀ.
    fn negative_eigenvalues(&self) -> usize {
        0
    }
}
