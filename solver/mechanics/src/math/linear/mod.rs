//! Direct solution of symmetric systems: the only module that names faer.
//!
//! (A + U Σ Uᵀ) x = b with A sparse, given by its lower triangle, and a few
//! columns U that are dense. The symbolic part is done once per pattern. Positive
//! definite A are factored as L Lᵀ, in single or in double precision, others as
//! L B Lᵀ; solutions are refined with the matrix itself in double precision, by
//! conjugate gradients or, where it is not positive definite, by iteration. The
//! dense part enters by the formula of Woodbury,
//!
//! (A + U Σ Uᵀ)⁻¹ = A⁻¹ − Z (Σ⁻¹ + Uᵀ Z)⁻¹ Zᵀ,   Z = A⁻¹ U
//!
//! Source: Golub and Van Loan, "Matrix Computations", sections 2.1.4 and 11.5.

mod conjugate_gradients;
mod elimination;
mod extend_add;
mod indefinite;
mod matrix;
mod multifrontal;
mod product;
mod replacing;
mod scalar;
mod substitution;
mod symbolic;
#[cfg(test)]
mod tests;
mod trapezoid;

use std::ops::Range;

use nalgebra::{DMatrix, DVector, Dyn, LU};
use rayon::prelude::*;

use crate::math::pool::Pool;
pub use conjugate_gradients::Outcome;
use conjugate_gradients::{Gradients, Stop, conjugate_gradients};
use indefinite::Indefinite;
use matrix::Triangle;

pub use matrix::{Symmetric, dot, norm, sum};
use multifrontal::{BadPivots, Fronts};
pub use product::product_speed;
use scalar::narrow;
pub use symbolic::one_by_one;
use symbolic::{Symbolic, symbolic};

/// The matrix has a pivot that is not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite: pivot {pivot} of {size} in elimination order")]
pub struct NotPositive {
    /// Position of the pivot in elimination order.
    pub pivot: usize,
    /// Number of unknowns.
    pub size: usize,
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

/// Relative residual of a solution that has come to rounding.
const SMALLEST_RESIDUAL: f64 = 1e-14;

/// Refinement steps of a solution, at most.
const REFINEMENTS: usize = 40;

/// Conjugate-gradient steps with the factor of another matrix that cost less
/// than a factor of its own.
const NEAR_STEPS: usize = 12;

/// Precision of a factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Half the memory and half the time; solutions take a few more steps of
    /// refinement, the more the worse the matrix is conditioned.
    Single,
    /// A solution is accurate without refinement.
    Double,
}

/// What the formula of Woodbury needs besides the factor of A.
struct Capacitance {
    /// A⁻¹ u_k
    columns: Vec<Vec<f64>>,
    /// Σ⁻¹ + Uᵀ A⁻¹ U
    matrix: LU<f64, Dyn, Dyn>,
}

enum Factor {
    None,
    Single(Vec<f32>),
    Double(Vec<f64>),
    Indefinite(Box<Indefinite>),
}

/// A factorisation that is set up once per sparsity pattern.
pub struct SparseSolver {
    pattern: Triangle,
    /// The unknown at each position of the factor.
    order: Vec<usize>,
    fronts: Fronts,
    /// Memory of updates in single precision.
    pool: Pool<f32>,
    /// Memory of the next factor in single precision.
    memory: Vec<f32>,
    factor: Factor,
    /// Matrix of the last factorisation.
    matrix: Symmetric,
    capacitance: Option<Capacitance>,
}

impl SparseSolver {
    /// Symbolic factorisation of a lower triangle in compressed columns. The unknowns are
    /// eliminated group by group in the given order, up to changes that leave the fill alone;
    /// those of a group are coupled with each other and with the same others.
    ///
    /// # Panics
    /// When the groups are not all unknowns, each once, when unknowns of a group have different
    /// neighbours, or when memory runs out.
    #[must_use]
    pub fn new(column_start: Vec<usize>, rows: Vec<usize>, groups: &[Range<usize>]) -> Self {
        let Symbolic { order, supernodes } = symbolic(&column_start, &rows, groups);
        let rows = rows.into_iter().map(narrow).collect();
        let pattern = Triangle { column_start, rows };
        let fronts = Fronts::new(supernodes, &pattern, &order);
        let matrix = Symmetric::sparse(Vec::new());
        let (pool, memory, factor) = (Pool::default(), Vec::new(), Factor::None);
        Self { pattern, order, fronts, pool, memory, factor, matrix, capacitance: None }
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.pattern.size()
    }

    /// Number of stored entries of the matrix.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.pattern.rows.len()
    }

    /// Position of the first stored entry of each column of the matrix, its diagonal.
    #[must_use]
    pub fn column_start(&self) -> &[usize] {
        &self.pattern.column_start
    }

    /// Number of stored entries of the factor.
    #[must_use]
    pub fn factor_len(&self) -> usize {
        self.fronts.factor_len()
    }

    /// Floating-point operations of a factorisation.
    #[must_use]
    pub fn factor_flops(&self) -> f64 {
        self.fronts.flops()
    }

    /// Part of [`Self::factor_flops`] in supernodes that must follow one another.
    #[must_use]
    pub fn chain_flops(&self) -> f64 {
        self.fronts.chain_flops()
    }

    /// Memory that a factorisation in single precision takes at most [B].
    #[must_use]
    pub fn factor_bytes(&self) -> usize {
        size_of::<f32>() * (self.factor_len() + self.fronts.updates_len())
    }

    /// The smallest pivot of the last factorisation, if its matrix is positive
    /// definite.
    #[must_use]
    pub fn smallest_pivot(&self) -> Option<Pivot> {
        let pivots: Vec<f64> = match &self.factor {
            Factor::Single(values) => self.fronts.pivots(values).map(f64::from).collect(),
            Factor::Double(values) => self.fronts.pivots(values).collect(),
            Factor::None | Factor::Indefinite(_) => return None,
        };
        let (position, &value) = pivots.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let largest = pivots.iter().fold(0.0_f64, |m, &p| m.max(p));
        Some(Pivot { value, largest, unknown: self.order[position] })
    }

    /// Factors a matrix whose sparse part is positive definite. Where single
    /// precision finds a pivot that is not positive, double precision decides.
    ///
    /// # Errors
    /// [`NotPositive`] at such a pivot.
    pub fn factor_positive(
        &mut self,
        matrix: Symmetric,
        precision: Precision,
    ) -> Result<(), NotPositive> {
        let size = self.size();
        self.begin(matrix);
        if precision == Precision::Single && self.factor_single(BadPivots::Refuse).is_ok() {
            return Ok(());
        }
        self.memory = Vec::new();
        let mut values = vec![0.0; self.factor_len()];
        self.fronts
            .factor(&self.matrix.lower, &mut values, &Pool::default(), BadPivots::Refuse)
            .map_err(|pivot| NotPositive { pivot, size })?;
        self.factor = Factor::Double(values);
        self.set_capacitance();
        Ok(())
    }

    /// Sets the matrix of the next factorisation and forgets the last one.
    fn begin(&mut self, matrix: Symmetric) {
        self.forget();
        self.matrix = matrix;
    }

    /// Factors the matrix in single precision. The result is the number of pivots that
    /// were replaced, or the position of one that was refused.
    fn factor_single(&mut self, bad_pivots: BadPivots) -> Result<usize, usize> {
        let mut values = std::mem::take(&mut self.memory);
        if values.len() != self.factor_len() {
            // pages of new memory are cleared where they are first written: in parallel
            values = Vec::new();
            let zeros = rayon::iter::repeat_n(0.0, self.factor_len());
            zeros.with_min_len(1 << 16).collect_into_vec(&mut values);
        }
        let result = self.fronts.factor(&self.matrix.lower, &mut values, &self.pool, bad_pivots);
        if result.is_err() {
            self.memory = values;
            return result;
        }
        self.factor = Factor::Single(values);
        self.set_capacitance();
        result
    }

    /// Factors a matrix in single precision as if it were positive definite: L Lᵀ = A + E,
    /// where E is nonzero at pivots that are not positive alone. Returns their number. For
    /// the solution see [`Self::solve_modified`].
    ///
    /// # Errors
    /// [`NotPositive`] where there are many such pivots.
    pub fn factor_modified(&mut self, matrix: Symmetric) -> Result<usize, NotPositive> {
        let size = self.size();
        self.begin(matrix);
        self.factor_single(BadPivots::ReplaceFew).map_err(|pivot| NotPositive { pivot, size })
    }

    /// Solves A x = b, to ‖A x − b‖ ≤ tolerance ‖b‖, by conjugate gradients with the factor
    /// of [`Self::factor_modified`], which meet a direction of negative curvature after a
    /// few steps if A is not positive definite.
    #[must_use]
    pub fn solve_modified(&self, b: &[f64], tolerance: f64) -> Outcome {
        let stop = Stop { tolerance, steps: REFINEMENTS, near: false };
        self.gradients(&self.matrix, b, &stop).outcome(tolerance)
    }

    /// Factors the last matrix in double precision if its factor is in single;
    /// false where that changes nothing.
    pub fn sharpen(&mut self) -> bool {
        if !matches!(self.factor, Factor::Single(_)) {
            return false;
        }
        let matrix = std::mem::replace(&mut self.matrix, Symmetric::sparse(Vec::new()));
        if self.factor_positive(matrix, Precision::Double).is_err() {
            let matrix = std::mem::replace(&mut self.matrix, Symmetric::sparse(Vec::new()));
            self.factor_indefinite(matrix);
        }
        true
    }

    /// Factors any symmetric matrix.
    pub fn factor_indefinite(&mut self, matrix: Symmetric) {
        self.begin(matrix);
        self.memory = Vec::new();
        let factor = Indefinite::new(&self.pattern, &self.order, &self.matrix.lower);
        self.factor = Factor::Indefinite(Box::new(factor));
        self.set_capacitance();
    }

    /// Prepares the dense part of the last matrix for solves.
    fn set_capacitance(&mut self) {
        let updates = &self.matrix.updates;
        if updates.is_empty() {
            return;
        }
        let mut columns: Vec<Vec<f64>> = updates.iter().map(|(_, u)| u.clone()).collect();
        columns.iter_mut().for_each(|z| self.apply_sparse_inverse(z));
        let matrix = DMatrix::from_fn(updates.len(), updates.len(), |i, j| {
            let diagonal = if i == j { 1.0 / updates[i].0 } else { 0.0 };
            diagonal + dot(&updates[i].1, &columns[j])
        });
        self.capacitance = Some(Capacitance { columns, matrix: matrix.lu() });
    }

    /// Solves with the last factorisation, to rounding, and returns the relative
    /// residual ‖A x − b‖ / ‖b‖ that was reached.
    ///
    /// # Panics
    /// Without a factorisation.
    pub fn solve(&self, rhs: &mut [f64]) -> f64 {
        let b = rhs.to_vec();
        self.solve_to(rhs, SMALLEST_RESIDUAL);
        // conjugate gradients only update theirs
        norm(&self.residual(&b, rhs)) / norm(&b).max(f64::MIN_POSITIVE)
    }

    /// Solves with the last factorisation to a relative residual, or to rounding
    /// where that is more, and returns the one that was reached.
    ///
    /// # Panics
    /// Without a factorisation.
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

    /// Solves for another matrix by conjugate gradients, preconditioned with the
    /// last factor, to ‖A x − b‖ ≤ tolerance ‖b‖. [`Outcome::Inaccurate`] where a
    /// factorisation is likely to be cheaper, or there is no positive factor.
    #[must_use]
    pub fn solve_near(&self, matrix: &Symmetric, b: &[f64], tolerance: f64) -> Outcome {
        if !self.is_positive() {
            return Outcome::Inaccurate;
        }
        let stop = Stop { tolerance, steps: NEAR_STEPS, near: true };
        self.gradients(matrix, b, &stop).outcome(tolerance)
    }

    /// Conjugate gradients preconditioned with the last factor.
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

    /// b − A x for the matrix of the last factorisation.
    fn residual(&self, b: &[f64], x: &[f64]) -> Vec<f64> {
        let ax = self.pattern.multiply(&self.matrix, x);
        b.iter().zip(&ax).map(|(b, a)| b - a).collect()
    }

    /// A⁻¹ x by the factor, without refinement.
    fn inverse_times(&self, x: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        self.apply_sparse_inverse(&mut x);
        let Some(Capacitance { columns, matrix }) = &self.capacitance else { return x };
        let updates = &self.matrix.updates;
        let projected =
            DVector::from_iterator(updates.len(), updates.iter().map(|(_, u)| dot(u, &x)));
        // singular only if the whole matrix is; the result is then NaN
        let weights = matrix.solve(&projected).unwrap_or_else(|| projected.map(|_| f64::NAN));
        for (z, weight) in columns.iter().zip(weights.iter()) {
            x.iter_mut().zip(z).for_each(|(x, z)| *x -= weight * z);
        }
        x
    }

    fn apply_sparse_inverse(&self, x: &mut [f64]) {
        match &self.factor {
            Factor::Single(values) => {
                // so that no residual is too small for single precision
                let size = norm(x).max(f64::MIN_POSITIVE);
                #[allow(clippy::cast_possible_truncation)]
                let mut y: Vec<f32> = self.order.iter().map(|&i| (x[i] / size) as f32).collect();
                self.fronts.solve(values, &mut y);
                self.order.iter().zip(y).for_each(|(&i, y)| x[i] = size * f64::from(y));
            }
            Factor::Double(values) => {
                let mut y: Vec<f64> = self.order.iter().map(|&i| x[i]).collect();
                self.fronts.solve(values, &mut y);
                self.order.iter().zip(y).for_each(|(&i, y)| x[i] = y);
            }
            Factor::Indefinite(factor) => factor.apply_inverse(x),
            Factor::None => panic!("solve needs a factorisation"),
        }
    }

    /// Whether the last factorisation is that of a positive definite matrix.
    #[must_use]
    pub fn is_positive(&self) -> bool {
        matches!(self.factor, Factor::Single(_) | Factor::Double(_))
    }

    /// Forgets the factorisation; the symbolic part and the memory stay.
    pub fn forget(&mut self) {
        if let Factor::Single(values) = std::mem::replace(&mut self.factor, Factor::None) {
            self.memory = values;
        }
        self.capacitance = None;
    }

    /// Makes way for the solver of another pattern, which gets the memory.
    pub fn replace(&mut self, by: Self) {
        self.forget();
        let (memory, pool) = (std::mem::take(&mut self.memory), std::mem::take(&mut self.pool));
        *self = Self { memory, pool, ..by };
    }
}
