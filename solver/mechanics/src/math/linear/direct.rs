//! How matrices are factored, and what that takes.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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
