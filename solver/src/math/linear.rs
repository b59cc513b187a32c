//! Direct solution of symmetric systems: the only file that names faer.
//!
//! (A + U Σ Uᵀ) x = b with A sparse, given by its lower triangle, and a few
//! columns U that are dense. The symbolic part is done once per pattern. Positive
//! definite A are factored as L Lᵀ, others as L B Lᵀ with pivoting inside the
//! supernodes; every solution with the latter is checked by its residual. The
//! dense part enters by the formula of Woodbury,
//!
//! (A + U Σ Uᵀ)⁻¹ = A⁻¹ − Z (Σ⁻¹ + Uᵀ Z)⁻¹ Zᵀ,   Z = A⁻¹ U
//!
//! Source: Golub and Van Loan, "Matrix Computations", section 2.1.4.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// The matrix has a pivot that is not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite: pivot {pivot} of {size} in elimination order")]
pub struct NotPositive {
    /// Position of the pivot in elimination order.
    pub pivot: usize,
    /// Number of unknowns.
    pub size: usize,
}

/// Refinement sweeps after a solve with an indefinite factor.
const REFINEMENTS: usize = 3;

/// Conjugate-gradient steps with a nearby factor that cost less than a new one.
const NEAR_STEPS: usize = 12;

/// A + Σ_k s_k u_k u_kᵀ.
#[derive(Clone, Debug)]
pub struct Symmetric {
    /// Values of the lower triangle of A, in compressed columns.
    pub lower: Vec<f64>,
    /// The pairs (s_k ≠ 0, u_k).
    pub updates: Vec<(f64, Vec<f64>)>,
}

impl Symmetric {
    /// A sparse matrix alone.
    #[must_use]
    pub fn sparse(lower: Vec<f64>) -> Self {
        Self { lower, updates: Vec::new() }
    }
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
    Positive,
    Indefinite { subdiagonal: Vec<f64>, forward: Vec<usize>, inverse: Vec<usize> },
}

/// A factorisation that is set up once per sparsity pattern.
pub struct SparseSolver {
    column_start: Vec<usize>,
    rows: Vec<usize>,
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
    scratch: MemBuffer,
    factor: Factor,
    /// Matrix of the last factorisation, for residuals.
    matrix: Symmetric,
    capacitance: Option<Capacitance>,
}

impl SparseSolver {
    /// Symbolic factorisation of a lower triangle in compressed columns.
    /// `order[i]` is the unknown eliminated at position i.
    ///
    /// # Panics
    /// When `order` is not a permutation of the unknowns or memory runs out.
    #[must_use]
    pub fn new(column_start: Vec<usize>, rows: Vec<usize>, order: &[usize]) -> Self {
        let n = column_start.len() - 1;
        let mut position = vec![0; n];
        for (i, &unknown) in order.iter().enumerate() {
            position[unknown] = i;
        }
        let permutation = PermRef::new_checked(order, &position, n);
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &column_start, None, &rows);
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            SymmetricOrdering::Custom(permutation),
            CholeskySymbolicParams::default(),
        )
        .expect("memory for the symbolic factorisation");
        let factor = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::rayon(0), Spec::default())
            .or(symbolic
                .factorize_numeric_intranode_lblt_scratch::<f64>(Par::rayon(0), Spec::default()));
        let scratch =
            MemBuffer::new(factor.or(symbolic.solve_in_place_scratch::<f64>(1, Par::rayon(0))));
        let values = vec![0.0; symbolic.len_val()];
        Self {
            column_start,
            rows,
            symbolic,
            values,
            scratch,
            factor: Factor::None,
            matrix: Symmetric::sparse(Vec::new()),
            capacitance: None,
        }
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Number of stored entries of the factor.
    #[must_use]
    pub fn factor_len(&self) -> usize {
        self.values.len()
    }

    /// Multiplications and additions of a numeric factorisation, as if dense
    /// columns: Σ (entries of the column)², zeros that are stored included.
    #[must_use]
    pub fn factor_flops(&self) -> f64 {
        let square = |entries: usize| (entries as f64).powi(2);
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(s) => {
                s.col_ptr().windows(2).map(|w| square(w[1] - w[0])).sum()
            }
            SymbolicCholeskyRaw::Supernodal(s) => (0..s.n_supernodes())
                .map(|k| {
                    let below = s.supernode(k).pattern().len();
                    let width = s.supernode_end()[k] - s.supernode_begin()[k];
                    (1..=width).map(|column| square(below + column)).sum::<f64>()
                })
                .sum(),
        }
    }

    /// Factors a matrix whose sparse part is positive definite.
    ///
    /// # Errors
    /// [`NotPositive`] at the first pivot that is not positive.
    pub fn factor_positive(&mut self, matrix: Symmetric) -> Result<(), NotPositive> {
        let size = self.size();
        let pattern =
            SymbolicSparseColMatRef::new_checked(size, size, &self.column_start, None, &self.rows);
        let result = self.symbolic.factorize_numeric_llt(
            &mut self.values,
            SparseColMatRef::new(pattern, &matrix.lower),
            Side::Lower,
            LltRegularization::default(),
            Par::rayon(0),
            MemStack::new(&mut self.scratch),
            Spec::default(),
        );
        let outcome = match result {
            Ok(_) => Ok(()),
            Err(LltError::NonPositivePivot { index }) => Err(NotPositive { pivot: index, size }),
        };
        self.factor = if outcome.is_ok() { Factor::Positive } else { Factor::None };
        self.matrix = matrix;
        self.set_capacitance();
        outcome
    }

    /// Factors any symmetric matrix.
    pub fn factor_indefinite(&mut self, matrix: Symmetric) {
        let n = self.size();
        let (mut subdiagonal, mut forward, mut inverse) = (vec![0.0; n], vec![0; n], vec![0; n]);
        let pattern =
            SymbolicSparseColMatRef::new_checked(n, n, &self.column_start, None, &self.rows);
        self.symbolic.factorize_numeric_intranode_lblt(
            &mut self.values,
            &mut subdiagonal,
            &mut forward,
            &mut inverse,
            SparseColMatRef::new(pattern, &matrix.lower),
            Side::Lower,
            Par::rayon(0),
            MemStack::new(&mut self.scratch),
            Spec::default(),
        );
        self.factor = Factor::Indefinite { subdiagonal, forward, inverse };
        self.matrix = matrix;
        self.set_capacitance();
    }

    /// Solves with the last factorisation and returns the relative residual
    /// ‖A x − b‖ / ‖b‖ that was reached.
    ///
    /// # Panics
    /// Without a factorisation.
    pub fn solve(&mut self, rhs: &mut [f64]) -> f64 {
        let b = rhs.to_vec();
        self.apply_inverse(rhs);
        let mut residual = self.residual(&b, rhs);
        if matches!(self.factor, Factor::Indefinite { .. }) {
            for _ in 0..REFINEMENTS {
                self.apply_inverse(&mut residual);
                for (x, r) in rhs.iter_mut().zip(&residual) {
                    *x += r;
                }
                residual = self.residual(&b, rhs);
            }
        }
        norm(&residual) / norm(&b).max(f64::MIN_POSITIVE)
    }

    /// Prepares the dense part of the last matrix for solves.
    fn set_capacitance(&mut self) {
        self.capacitance = None;
        let updates = &self.matrix.updates;
        if updates.is_empty() || matches!(self.factor, Factor::None) {
            return;
        }
        let mut columns: Vec<Vec<f64>> = updates.iter().map(|(_, u)| u.clone()).collect();
        columns.iter_mut().for_each(|z| self.apply_sparse_inverse(z));
        let updates = &self.matrix.updates;
        let matrix = DMatrix::from_fn(updates.len(), updates.len(), |i, j| {
            let diagonal = if i == j { 1.0 / updates[i].0 } else { 0.0 };
            diagonal + dot(&updates[i].1, &columns[j])
        });
        self.capacitance = Some(Capacitance { columns, matrix: matrix.lu() });
    }

    /// x ← A⁻¹ x by the factor, without a residual.
    ///
    /// # Panics
    /// Without a factorisation.
    pub fn apply_inverse(&mut self, x: &mut [f64]) {
        self.apply_sparse_inverse(x);
        let Some(Capacitance { columns, matrix }) = &self.capacitance else { return };
        let updates = &self.matrix.updates;
        let projected =
            DVector::from_iterator(updates.len(), updates.iter().map(|(_, u)| dot(u, x)));
        // singular only if the whole matrix is; NaN then tells it
        let weights = matrix.solve(&projected).unwrap_or_else(|| projected.map(|_| f64::NAN));
        for (z, weight) in columns.iter().zip(weights.iter()) {
            x.iter_mut().zip(z).for_each(|(x, z)| *x -= weight * z);
        }
    }

    fn apply_sparse_inverse(&mut self, x: &mut [f64]) {
        let n = self.size();
        let rhs = MatMut::from_column_major_slice_mut(x, n, 1);
        let stack = MemStack::new(&mut self.scratch);
        match &self.factor {
            Factor::Positive => LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
                Conj::No,
                rhs,
                Par::Seq,
                stack,
            ),
            Factor::Indefinite { subdiagonal, forward, inverse } => {
                let permutation = PermRef::new_checked(forward, inverse, n);
                IntranodeLbltRef::new(&self.symbolic, &self.values, subdiagonal, permutation)
                    .solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack);
            }
            Factor::None => panic!("solve needs a factorisation"),
        }
    }

    /// Whether the last factorisation is that of a positive definite matrix.
    #[must_use]
    pub fn is_positive(&self) -> bool {
        matches!(self.factor, Factor::Positive)
    }

    /// Forgets the factorisation; the symbolic part stays.
    pub fn forget(&mut self) {
        self.factor = Factor::None;
        self.capacitance = None;
    }

    /// Solves for another matrix by conjugate gradients, preconditioned with the
    /// last factor, to ‖A x − b‖ ≤ tolerance ‖b‖. None where a factorisation
    /// is likely to be cheaper, there is no positive factor, or the matrix
    /// proves indefinite.
    pub fn solve_near(
        &mut self,
        matrix: &Symmetric,
        b: &[f64],
        tolerance: f64,
    ) -> Option<Vec<f64>> {
        if !self.is_positive() {
            return None;
        }
        let mut x = vec![0.0; b.len()];
        let mut r = b.to_vec();
        let mut z = r.clone();
        self.apply_inverse(&mut z);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let wanted = tolerance * norm(b);
        for step in 1..=NEAR_STEPS {
            let ap = self.multiply(matrix, &p);
            let curvature = dot(&p, &ap);
            if curvature <= 0.0 {
                return None;
            }
            let alpha = rz / curvature;
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
            r.iter_mut().zip(&ap).for_each(|(r, a)| *r -= alpha * a);
            let residual = norm(&r);
            if residual <= wanted {
                return Some(x);
            }
            if hopeless(step, residual / norm(b), tolerance) {
                return None;
            }
            z.copy_from_slice(&r);
            self.apply_inverse(&mut z);
            let next = dot(&r, &z);
            let beta = next / rz;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + beta * *p);
            rz = next;
        }
        None
    }

    /// The product of a matrix and a vector.
    fn multiply(&self, matrix: &Symmetric, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (column, bounds) in self.column_start.windows(2).enumerate() {
            let entries = bounds[0]..bounds[1];
            for (&row, &value) in self.rows[entries.clone()].iter().zip(&matrix.lower[entries]) {
                y[row] += value * x[column];
                if row != column {
                    y[column] += value * x[row];
                }
            }
        }
        for (scale, u) in &matrix.updates {
            let along = scale * dot(u, x);
            y.iter_mut().zip(u).for_each(|(y, u)| *y += along * u);
        }
        y
    }

    /// b − A x for the matrix of the last factorisation.
    fn residual(&self, b: &[f64], x: &[f64]) -> Vec<f64> {
        let ax = self.multiply(&self.matrix, x);
        b.iter().zip(&ax).map(|(b, a)| b - a).collect()
    }
}

/// Whether conjugate gradients that have come to `residual` in `step` steps will
/// not reach the tolerance at this rate.
fn hopeless(step: usize, residual: f64, tolerance: f64) -> bool {
    let rate = residual.powf(1.0 / step as f64);
    step >= 3 && rate.powi(NEAR_STEPS as i32) > tolerance
}

/// Euclidean norm.
#[must_use]
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Scalar product.
#[must_use]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lower triangle of the 1D Laplacian of n points plus `shift` I.
    fn laplacian(n: usize, shift: f64) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let (mut start, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for c in 0..n {
            rows.push(c);
            values.push(2.0 + shift);
            if c + 1 < n {
                rows.push(c + 1);
                values.push(-1.0);
            }
            start.push(rows.len());
        }
        (start, rows, values)
    }

    #[test]
    fn positive_and_indefinite_systems_are_solved_to_rounding() {
        let n = 300;
        let (start, rows, values) = laplacian(n, 0.0);
        let order: Vec<usize> = (0..n).rev().collect();
        let mut solver = SparseSolver::new(start, rows, &order);
        let b: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();

        solver.factor_positive(Symmetric::sparse(values)).expect("eigenvalues are 2 - 2 cos > 0");
        // the condition number is 4/π² n² = 4e4
        assert!(solver.solve(&mut b.clone()) < 1e-11);
        let (_, _, near) = laplacian(n, 1e-6);
        let near = Symmetric::sparse(near);
        let x = solver.solve_near(&near, &b, 1e-11).expect("a shift of 1e-6 is near");
        let error: Vec<f64> =
            solver.multiply(&near, &x).iter().zip(&b).map(|(a, b)| a - b).collect();
        assert!(norm(&error) < 1e-10 * norm(&b));
        let far = Symmetric::sparse(laplacian(n, 100.0).2);
        assert!(solver.solve_near(&far, &b, 1e-11).is_none());

        // two entries in every column but the last, and zeros between supernodes
        assert!(solver.factor_flops() >= 4.0 * (n - 1) as f64 + 1.0);
        assert!(solver.factor_flops() <= (n * n * n) as f64);

        // not -1: its second leading minor is zero, where pivoting within one
        // column cannot help
        let shifted = Symmetric::sparse(laplacian(n, -0.9).2);
        let failed = solver.factor_positive(shifted.clone());
        assert!(failed.is_err_and(|e| e.pivot < n && e.size == n));
        solver.factor_indefinite(shifted);
        assert!(solver.solve(&mut b.clone()) < 1e-11);
    }

    #[test]
    fn dense_columns_enter_without_being_assembled() {
        let n = 40;
        let order: Vec<usize> = (0..n).rev().collect();
        let column = |k: f64| -> Vec<f64> { (0..n).map(|i| (k * i as f64).sin()).collect() };
        let updates = vec![(3.0, column(0.1)), (1e4, column(0.37))];
        let b = column(1.3);
        for shift in [0.0, -0.9] {
            let (start, rows, lower) = laplacian(n, shift);
            let mut assembled = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
                0 => 2.0 + shift,
                1 => -1.0,
                _ => 0.0,
            });
            for (scale, u) in &updates {
                let u = DVector::from_column_slice(u);
                assembled += *scale * &u * u.transpose();
            }
            let expected = assembled.lu().solve(&DVector::from_column_slice(&b)).expect("regular");
            let mut solver = SparseSolver::new(start, rows, &order);
            let matrix = Symmetric { lower, updates: updates.clone() };
            if solver.factor_positive(matrix.clone()).is_err() {
                solver.factor_indefinite(matrix);
            }
            let mut x = b.clone();
            assert!(solver.solve(&mut x) < 1e-9);
            let error: Vec<f64> = x.iter().zip(expected.iter()).map(|(a, b)| a - b).collect();
            assert!(norm(&error) < 1e-9 * norm(&x), "{}", norm(&error));
        }
    }
}
