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

#[cfg(test)]
mod tests {
    use super::*;

    /// One row: d = v M⁻¹ a / (a · M⁻¹ a).
    #[test]
    fn what_moves_much_is_moved_less() {
        let rows = [Row { a: vec![(0, 1.0), (2, 2.0)], c: -1.0, of: None }];
        let metric = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0, 8.0]));
        for (metric, expected) in [(Some(metric), [2.0, 0.0, 0.5]), (None, [0.6, 0.0, 1.2])] {
            let found = LeastMotion::new(metric).step(&rows, &[3.0], 3).expect("a step");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{found} {expected}");
            }
        }
    }
}
