//! Symmetric matrices whose sparse part has a fixed sparsity pattern.

use std::ops::Range;

use rayon::prelude::*;

use super::scalar::narrow;

/// Parts into which a product is cut. A constant, so that it has the same bits
/// for any number of threads.
const PARTS: usize = 4;

/// Length of the pieces by which threads share vectors, and a scalar product is summed up.
pub(super) const PIECE: usize = 1 << 14;

/// Columns that a product goes through side by side, at most: those of the directions of a node.
const GROUP: usize = 3;

/// The lower triangle of a sparse matrix in compressed columns.
pub struct Triangle {
    /// First entry of each column.
    pub column_start: Vec<usize>,
    /// Row of each entry, ascending; a column begins with its diagonal.
    pub rows: Vec<u32>,
    /// Columns one after the other that are full on their diagonal and have the same rows below.
    groups: Vec<Range<usize>>,
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
        let groups = groups(&column_start, rows);
        Self { column_start, rows: rows.iter().map(|&row| narrow(row)).collect(), groups }
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
        let before = |group: &Range<usize>| self.column_start[group.start];
        let cut = |part: usize| self.groups.partition_point(|g| before(g) * PARTS < part * entries);
        let parts: Vec<Vec<f64>> = (0..PARTS)
            .into_par_iter()
            .map(|p| self.multiply_groups(&matrix.lower, x, &self.groups[cut(p)..cut(p + 1)]))
            .collect();
        let mut y = sum(parts);
        for (scale, u) in &matrix.updates {
            add_scaled(&mut y, scale * dot(u, x), u);
        }
        y
    }

    /// What some columns, and the rows that mirror them, add to a product.
    fn multiply_groups(&self, lower: &[f64], x: &[f64], groups: &[Range<usize>]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for group in groups {
            match group.len() {
                3 => self.multiply_group::<3>(lower, x, group.start, &mut y),
                2 => self.multiply_group::<2>(lower, x, group.start, &mut y),
                _ => self.multiply_group::<1>(lower, x, group.start, &mut y),
            }
        }
        y
    }

    fn multiply_group<const N: usize>(
        &self,
        lower: &[f64],
        x: &[f64],
        first: usize,
        y: &mut [f64],
    ) {
        let at: [f64; N] = std::array::from_fn(|j| x[first + j]);
        let columns: [&[f64]; N] = std::array::from_fn(|j| {
            &lower[self.column_start[first + j]..self.column_start[first + j + 1]]
        });
        let mut sums = [0.0; N];
        for j in 0..N {
            sums[j] += columns[j][0] * at[j];
            for i in j + 1..N {
                let value = columns[j][i - j];
                sums[i] += value * at[j];
                sums[j] += value * at[i];
            }
        }
        let below = &self.rows[self.column_start[first] + N..self.column_start[first + 1]];
        let columns: [&[f64]; N] = std::array::from_fn(|j| &columns[j][N - j..][..below.len()]);
        for (k, &row) in below.iter().enumerate() {
            let (row, mut added) = (row as usize, 0.0);
            let there = x[row];
            for j in 0..N {
                added += columns[j][k] * at[j];
                sums[j] += columns[j][k] * there;
            }
            y[row] += added;
        }
        (0..N).for_each(|j| y[first + j] += sums[j]);
    }
}

/// Columns in groups, as [`Triangle`] has them.
fn groups(column_start: &[usize], rows: &[usize]) -> Vec<Range<usize>> {
    let column = |c: usize| &rows[column_start[c]..column_start[c + 1]];
    let (mut groups, mut first): (Vec<Range<usize>>, usize) = (Vec::new(), 0);
    for c in 1..column_start.len() {
        let full = c + 1 == column_start.len() || column(c - 1)[1..] != *column(c);
        if full || c - first == GROUP {
            groups.push(first..c);
            first = c;
        }
    }
    groups
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
        add_scaled(&mut total, 1.0, vector.as_ref());
    }
    total
}

/// y ← y + `scale` x.
pub fn add_scaled(y: &mut [f64], scale: f64, x: &[f64]) {
    let add = |y: &mut [f64], x: &[f64]| y.iter_mut().zip(x).for_each(|(y, x)| *y += scale * x);
    if y.len() <= PIECE {
        return add(y, x);
    }
    y.par_chunks_mut(PIECE).zip(x.par_chunks(PIECE)).for_each(|(y, x)| add(y, x));
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Groups of one to three columns, and one of seven that is cut.
    #[test]
    fn products_are_those_of_the_full_matrix() {
        let groups = [0..3, 3..4, 4..6, 6..13, 13..16];
        let coupled = [(0, 0), (0, 2), (0, 4), (1, 1), (1, 2), (2, 2), (2, 4), (3, 3), (4, 4)];
        let of: Vec<usize> =
            groups.iter().enumerate().flat_map(|(g, range)| vec![g; range.len()]).collect();
        let (mut start, mut rows) = (vec![0], Vec::new());
        for c in 0..16 {
            rows.extend((c..16).filter(|&row| coupled.contains(&(of[c], of[row]))));
            start.push(rows.len());
        }
        let triangle = Triangle::new(start, &rows);
        let sizes: Vec<usize> = triangle.groups.iter().map(ExactSizeIterator::len).collect();
        assert_eq!(sizes, [3, 1, 2, 3, 3, 1, 3]);
        let lower: Vec<f64> = (0..rows.len()).map(|k| (k as f64).cos()).collect();
        let x: Vec<f64> = (0..16).map(|i| (i as f64).sin()).collect();
        let mut expected = vec![0.0; 16];
        for c in 0..16 {
            for k in triangle.column_start[c]..triangle.column_start[c + 1] {
                expected[rows[k]] += lower[k] * x[c];
                if rows[k] != c {
                    expected[c] += lower[k] * x[rows[k]];
                }
            }
        }
        let product = triangle.multiply(&Symmetric::sparse(lower), &x);
        assert!(product.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}
