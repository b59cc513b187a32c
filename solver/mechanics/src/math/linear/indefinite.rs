//! L B Lᵀ of a symmetric matrix that need not be positive definite, with
//! pivoting inside the supernodes.
//!
//! B has as many negative eigenvalues as the matrix (Sylvester's law of inertia; Golub and Van Loan,
//! "Matrix Computations", section 8.1). Its blocks of two are indefinite: Bunch and Kaufman take
//! them where d₁ d₂ < s².

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{IntranodeLbltRef, SymbolicCholesky, SymbolicCholeskyRaw};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::matrix::Triangle;
use super::symbolic::factor_structure;

/// The numbers of a factor.
pub struct Indefinite {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
    subdiagonal: Vec<f64>,
    forward: Vec<usize>,
    inverse: Vec<usize>,
}

impl Indefinite {
    /// Factors the matrix with the given lower triangle; `order[i]` is the unknown at
    /// position i.
    pub fn new(pattern: &Triangle, order: &[usize], lower: &[f64]) -> Self {
        let n = pattern.size();
        let rows: Vec<usize> = pattern.rows.iter().map(|&row| row as usize).collect();
        let symbolic = factor_structure(&pattern.column_start, &rows, order, 1);
        let mut factor = Self {
            values: vec![0.0; symbolic.len_val()],
            subdiagonal: vec![0.0; n],
            forward: vec![0; n],
            inverse: vec![0; n],
            symbolic,
        };
        let matrix = SymbolicSparseColMatRef::new_checked(n, n, &pattern.column_start, None, &rows);
        let scratch = factor
            .symbolic
            .factorize_numeric_intranode_lblt_scratch::<f64>(Par::rayon(0), Spec::default());
        factor.symbolic.factorize_numeric_intranode_lblt(
            &mut factor.values,
            &mut factor.subdiagonal,
            &mut factor.forward,
            &mut factor.inverse,
            SparseColMatRef::new(matrix, lower),
            Side::Lower,
            Par::rayon(0),
            MemStack::new(&mut MemBuffer::new(scratch)),
            Spec::default(),
        );
        factor
    }

    /// The diagonal of B in the order of elimination.
    fn diagonal(&self) -> Vec<f64> {
        let SymbolicCholeskyRaw::Supernodal(fronts) = self.symbolic.raw() else {
            // forced out by the threshold, unless there are no unknowns
            return Vec::new();
        };
        let (begin, end) = (fronts.supernode_begin(), fronts.supernode_end());
        let first = fronts.col_ptr_for_val();
        let of_front = |k: usize| {
            let width = end[k] - begin[k];
            let height = width + fronts.supernode(k).pattern().len();
            let own = &self.values[first[k]..first[k] + width * height];
            own.iter().step_by(height + 1).take(width).copied()
        };
        (0..fronts.n_supernodes()).flat_map(of_front).collect()
    }

    /// x ← A⁻¹ x.
    pub fn apply_inverse(&self, x: &mut [f64]) {
        let n = x.len();
        let permutation = PermRef::new_checked(&self.forward, &self.inverse, n);
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        IntranodeLbltRef::new(&self.symbolic, &self.values, &self.subdiagonal, permutation)
            .solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(x, n, 1),
                Par::Seq,
                MemStack::new(&mut MemBuffer::new(scratch)),
            );
    }

    /// Number of negative eigenvalues of the matrix.
    pub fn negative_eigenvalues(&self) -> usize {
        let diagonal = self.diagonal();
        let (mut negative, mut i) = (0, 0);
        while i < diagonal.len() {
            let single = self.subdiagonal[i] == 0.0;
            negative += usize::from(!single || diagonal[i] < 0.0);
            i += if single { 1 } else { 2 };
        }
        negative
    }
}
