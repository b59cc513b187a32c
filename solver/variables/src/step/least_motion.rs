//! The shortest step back to what is kept.

use nalgebra::{DMatrix, DVector};

use super::Row;

/// Regularisation of a metric, over its mean diagonal.
const SINGULAR: f64 = 1e-9;
/// Regularisation where inequalities contradict each other, over the mean diagonal.
const CONTRADICTIONS: f64 = 1e-8;

/// d = M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁻¹ v, with a metric M or the same in all directions.
pub struct LeastMotion {
    /// M⁻¹.
    inverse: Option<DMatrix<f64>>,
}

impl LeastMotion {
    /// In the mean square of a metric; without one all variables count the same.
    pub fn new(metric: Option<DMatrix<f64>>) -> Self {
        let inverse = |metric: DMatrix<f64>| {
            let n = metric.nrows();
            let least = SINGULAR * metric.trace() / n as f64;
            (metric + least * DMatrix::identity(n, n)).try_inverse()
        };
        Self { inverse: metric.and_then(inverse) }
    }

    /// The shortest step along which rows in so many variables gain what they lack, to first order.
    pub fn step(&self, rows: &[Row], lacks: &[f64], variables: usize) -> Option<Vec<f64>> {
        let mut a = DMatrix::zeros(rows.len(), variables);
        for (k, row) in rows.iter().enumerate() {
            row.a.iter().for_each(|(i, by)| a[(k, *i)] = *by);
        }
        let along = match &self.inverse {
            Some(inverse) => &a * inverse,
            None => a.clone(),
        };
        let mut inner = &along * a.transpose();
        let least = CONTRADICTIONS * inner.trace() / rows.len() as f64;
        (0..rows.len()).for_each(|k| inner[(k, k)] += least);
        let pulls = inner.cholesky()?.solve(&DVector::from_column_slice(lacks));
        Some(along.tr_mul(&pulls).as_slice().to_vec())
    }
}
