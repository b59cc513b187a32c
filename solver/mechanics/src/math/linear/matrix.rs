//! Symmetric matrices whose sparse part has a fixed sparsity pattern.

use std::ops::Range;

use rayon::prelude::*;

use super::scalar::narrow;

/// Parts into which a product is cut. A constant, so that it has the same bits
/// for any number of threads.
const PARTS: usize = 4;

/// Length of the pieces that a scalar product is summed up by.
const PIECE: usize = 1 << 14;

/// The lower triangle of a sparse matrix in compressed columns.
pub struct Triangle {
    /// First entry of each column.
    pub column_start: Vec<usize>,
    /// Row of each entry; a column begins with its diagonal.
    pub rows: Vec<u32>,
}

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

impl Triangle {
    /// A triangle in compressed columns.
    ///
    /// # Panics
    /// When it has 2³² rows.
    #[must_use]
    pub fn new(column_start: Vec<usize>, rows: &[usize]) -> Self {
        Self { column_start, rows: rows.iter().map(|&row| narrow(row)).collect() }
    }

    /// Number of columns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.column_start.len() - 1
    }

    /// The product of a matrix and a vector.
    #[must_use]
    pub fn multiply(&self, matrix: &Symmetric, x: &[f64]) -> Vec<f64> {
        let entries = self.rows.len();
        let cut = |part: usize| self.column_start.partition_point(|&s| s * PARTS < part * entries);
        let mut parts: Vec<Vec<f64>> = (0..PARTS)
            .into_par_iter()
            .map(|p| self.multiply_columns(&matrix.lower, x, cut(p)..cut(p + 1)))
            .collect();
        let mut y = parts.swap_remove(0);
        for part in parts {
            y.iter_mut().zip(part).for_each(|(y, p)| *y += p);
        }
        for (scale, u) in &matrix.updates {
            let along = scale * dot(u, x);
            y.iter_mut().zip(u).for_each(|(y, u)| *y += along * u);
        }
        y
    }

    /// What some columns, and the rows that mirror them, add to a product.
    fn multiply_columns(&self, lower: &[f64], x: &[f64], columns: Range<usize>) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in columns.start..columns.end.min(self.size()) {
            let entries = self.column_start[column]..self.column_start[column + 1];
            let (mut sum, at) = (0.0, x[column]);
            for (&row, &value) in self.rows[entries.clone()].iter().zip(&lower[entries]) {
                let row = row as usize;
                y[row] += value * at;
                if row != column {
                    sum += value * x[row];
                }
            }
            y[column] += sum;
        }
        y
    }
}

/// Euclidean norm.
#[must_use]
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Σ of vectors of one length; of none an empty one.
#[must_use]
pub fn sum<V: AsRef<[f64]>>(vectors: impl IntoIterator<Item = V>) -> Vec<f64> {
    let mut vectors = vectors.into_iter();
    let mut total = vectors.next().map_or_else(Vec::new, |first| first.as_ref().to_vec());
    for vector in vectors {
        total.iter_mut().zip(vector.as_ref()).for_each(|(sum, by)| *sum += by);
    }
    total
}

/// Scalar product. Summed up by pieces of constant length, so that it has the same bits
/// for any number of threads.
#[must_use]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    if x.len() <= PIECE {
        return dot_of_piece(x, y);
    }
    let pieces = x.par_chunks(PIECE).zip(y.par_chunks(PIECE));
    let sums: Vec<f64> = pieces.map(|(x, y)| dot_of_piece(x, y)).collect();
    sums.iter().sum()
}

/// With as many sums as fill a few wide vectors.
fn dot_of_piece(x: &[f64], y: &[f64]) -> f64 {
    const WIDTH: usize = 16;
    let mut sums = [0.0; WIDTH];
    let (x, x_rest) = x.as_chunks::<WIDTH>();
    let (y, y_rest) = y.as_chunks::<WIDTH>();
    for (x, y) in x.iter().zip(y) {
        for k in 0..WIDTH {
            sums[k] += x[k] * y[k];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}
