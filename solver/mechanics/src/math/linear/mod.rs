//! Direct solution of symmetric systems: the only module that names faer.
//!
//! (A + U Σ Uᵀ) x = b with A sparse, given by its lower triangle, and a few
//! columns U that are dense. The symbolic part is done once per pattern. Positive
//! definite A are factored as L Lᵀ, in single or in double precision, others as
//! L B Lᵀ; solutions are refined with the matrix itself in double precision, by
//! conjugate gradients or, where it is not positive definite, by iteration.
//!
//! Source: Golub and Van Loan, "Matrix Computations", sections 2.1.4 and 11.5.

mod cholesky;
mod columns;
mod conjugate_gradients;
mod direct;
mod elimination;
mod entries;
mod extend_add;
mod factorization;
mod indefinite;
mod matrix;
mod multifrontal;
mod replacing;
mod rows;
mod scalar;
mod several;
mod substitution;
mod supernode;
mod symbolic;
#[cfg(test)]
mod tests;
mod trapezoid;
mod unknown;

use std::ops::Range;
use std::sync::Arc;

use self::cholesky::{Factor, Multifrontal};
use self::direct::BadPivots;

pub use conjugate_gradients::Outcome;
pub use direct::{Cost, Memory, Pivot, Precision};
pub use factorization::Factorization;
pub use matrix::{Symmetric, Triangle, dot, norm, sum};
pub use rows::{Row, SYSTEMS};
pub use symbolic::one_by_one;

/// The matrix has a pivot that is not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite: pivot {pivot} of {size} in elimination order")]
pub struct NotPositive {
    /// Position of the pivot in elimination order.
    pub pivot: usize,
    /// Number of unknowns.
    pub size: usize,
}

/// A direct solver that is set up once per sparsity pattern, and the last factorisation.
pub struct SparseSolver {
    pattern: Arc<Triangle>,
    direct: Multifrontal,
    memory: Memory,
    last: Option<Arc<Factorization>>,
}

impl SparseSolver {
    /// Symbolic factorisation of a lower triangle in compressed columns. The unknowns are
    /// eliminated group by group in the given order, up to changes that leave the fill alone;
    /// those of a group are coupled with each other and with the same others.
    ///
    /// # Panics
    /// When the groups are not all unknowns, each once, when unknowns of a group have different
    /// neighbours, or when memory runs out.
    pub fn new(column_start: Vec<usize>, rows: &[usize], groups: &[Range<usize>]) -> Self {
        Self::with(Triangle::new(column_start, rows), groups, Memory::default())
    }

    /// That of a pattern, with the memory of an earlier one.
    pub fn with(pattern: Triangle, groups: &[Range<usize>], memory: Memory) -> Self {
        let pattern = Arc::new(pattern);
        let direct = Multifrontal::new(&pattern, groups, &memory);
        Self { pattern, direct, memory, last: None }
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.pattern.size()
    }

    /// The product of a matrix of the pattern and a vector.
    pub fn multiply(&self, matrix: &Symmetric, x: &[f64]) -> Vec<f64> {
        self.pattern.multiply(matrix, x)
    }

    /// Number of stored entries of the matrix.
    pub fn entries(&self) -> usize {
        self.pattern.rows.len()
    }

    /// Position of the first stored entry of each column of the matrix, its diagonal.
    pub fn column_start(&self) -> &[usize] {
        &self.pattern.column_start
    }

    /// What a factorisation takes.
    pub fn cost(&self) -> Cost {
        self.direct.cost()
    }

    /// The last factorisation; none before the first, and after one that failed.
    pub fn last(&self) -> Option<&Factorization> {
        self.last.as_deref()
    }

    /// Factors a matrix whose sparse part is positive definite. Where single
    /// precision finds a pivot that is not positive, double precision decides.
    pub fn factor_positive(
        &mut self,
        matrix: Symmetric,
        precision: Precision,
    ) -> Result<&Factorization, NotPositive> {
        self.forget();
        let factorization = self.positive(matrix, precision)?;
        Ok(self.last.insert(Arc::new(factorization)))
    }

    /// [`Self::factor_positive`] for the caller to keep.
    pub fn positive(
        &self,
        matrix: Symmetric,
        precision: Precision,
    ) -> Result<Factorization, NotPositive> {
        let (factor, precision) = self.cholesky(&matrix.lower, precision)?;
        Ok(Factorization::new(&self.pattern, matrix, factor, Some(precision)))
    }

    /// L Lᵀ, and the precision that it has.
    fn cholesky(
        &self,
        lower: &[f64],
        precision: Precision,
    ) -> Result<(Factor, Precision), NotPositive> {
        let factor = |precision| {
            let factored = self.direct.factor_positive(lower, precision, BadPivots::Refuse);
            factored.map(|(factor, _)| (factor, precision))
        };
        let factored = match factor(precision) {
            Err(_) if precision == Precision::Single => factor(Precision::Double),
            factored => factored,
        };
        factored.map_err(|pivot| self.not_positive(pivot))
    }

    fn not_positive(&self, pivot: usize) -> NotPositive {
        NotPositive { pivot, size: self.size() }
    }

    /// Factors a matrix in single precision as if it were positive definite: L Lᵀ = A + E,
    /// where E is nonzero at pivots that are not positive alone. Returns their number, too. For
    /// the solution see [`Factorization::solve_modified`].
    pub fn factor_modified(
        &mut self,
        matrix: Symmetric,
    ) -> Result<(&Factorization, usize), NotPositive> {
        self.forget();
        let (precision, few) = (Precision::Single, BadPivots::ReplaceFew);
        let factored = self.direct.factor_positive(&matrix.lower, precision, few);
        let (factor, replaced) = factored.map_err(|pivot| self.not_positive(pivot))?;
        Ok((self.keep(matrix, factor, Some(precision)), replaced))
    }

    /// Factors any symmetric matrix: as [`Self::factor_positive`] does if it is positive definite.
    pub fn factor(&mut self, matrix: Symmetric, precision: Precision) -> &Factorization {
        self.forget();
        match self.cholesky(&matrix.lower, precision) {
            Ok((factor, precision)) => self.keep(matrix, factor, Some(precision)),
            Err(_) => self.factor_indefinite(matrix),
        }
    }

    /// Factors a symmetric matrix as one that is not positive definite.
    pub fn factor_indefinite(&mut self, matrix: Symmetric) -> &Factorization {
        self.forget();
        let factor = self.direct.factor_indefinite(&matrix.lower);
        self.keep(matrix, factor, None)
    }

    /// Factors the last matrix in double precision if its factor is in single; none where that
    /// changes nothing.
    pub fn refactor_double(&mut self) -> Option<&Factorization> {
        let last = self.last.take_if(|last| last.positive == Some(Precision::Single))?;
        let matrix = Arc::try_unwrap(last)
            .map_or_else(|shared| shared.matrix().clone(), Factorization::into_matrix);
        Some(self.factor(matrix, Precision::Double))
    }

    fn keep(
        &mut self,
        matrix: Symmetric,
        factor: Factor,
        positive: Option<Precision>,
    ) -> &Factorization {
        self.last.insert(Arc::new(Factorization::new(&self.pattern, matrix, factor, positive)))
    }

    /// The last factorisation, for the caller to keep as well.
    pub fn share(&self) -> Option<Arc<Factorization>> {
        self.last.clone()
    }

    /// Makes one that was kept the last factorisation again; false where it is of another pattern.
    pub fn reuse(&mut self, kept: &Arc<Factorization>) -> bool {
        let fits = kept.is_of(&self.pattern);
        if fits {
            self.last = Some(Arc::clone(kept));
        }
        fits
    }

    /// Forgets the factorisation; the symbolic part and the memory stay.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// The memory that its factorisations use again, for the solver of another pattern.
    pub fn memory(&self) -> Memory {
        self.memory.clone()
    }
}
