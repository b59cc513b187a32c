//! Symmetric matrices whose sparse part has a fixed sparsity pattern.

use std::ops::Range;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::rows::{Row, SYSTEMS};
use super::scalar::narrow;
use super::unknown::Unknown;
use crate::math::lanes::widest;

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
    pub fn sparse(lower: Vec<f64>) -> Self {
        Self { lower, updates: Vec::new() }
    }
}

impl Triangle {
    /// A triangle in compressed columns.
    pub fn new(column_start: Vec<usize>, rows: &[usize]) -> Self {
        let groups = groups(&column_start, rows);
        Self { column_start, rows: rows.iter().map(|&row| narrow(row)).collect(), groups }
    }

    /// Number of columns.
    pub fn size(&self) -> usize {
        self.column_start.len() - 1
    }

    /// The product of a matrix and a vector.
    pub fn multiply(&self, matrix: &Symmetric, x: &[f64]) -> Vec<f64> {
        let mut y =
            sum(self.by_parts(x, |groups, y| self.add_product(&matrix.lower, x, groups, y)));
        for (scale, u) in &matrix.updates {
            add_scaled(&mut y, scale * dot(u, x), u);
        }
        y
    }

    /// The products of the sparse part of a matrix and a vector of each of several systems.
    pub(super) fn multiply_several(&self, matrix: &Symmetric, x: &[Row<f64>]) -> Vec<Row<f64>> {
        let parts = self.by_parts(x, |groups, y| {
            widest(AddProduct { triangle: self, lower: &matrix.lower, x, groups, y });
        });
        let mut parts = parts.into_iter();
        let mut y = parts.next().unwrap_or_default();
        for part in parts {
            let pairs = y.par_iter_mut().zip(part).with_min_len(PIECE / SYSTEMS);
            pairs.for_each(|(y, part)| *y = y.plus(1.0, part));
        }
        y
    }

    /// What parts of the columns, and the rows that mirror them, add to a product.
    fn by_parts<X: Unknown<f64>>(
        &self,
        x: &[X],
        add: impl Fn(&[Range<usize>], &mut [X]) + Sync,
    ) -> Vec<Vec<X>> {
        let entries = self.rows.len();
        let before = |group: &Range<usize>| self.column_start[group.start];
        let cut = |part: usize| self.groups.partition_point(|g| before(g) * PARTS < part * entries);
        let part = |p: usize| {
            let mut y = vec![X::zero(); x.len()];
            add(&self.groups[cut(p)..cut(p + 1)], &mut y);
            y
        };
        (0..PARTS).into_par_iter().map(part).collect()
    }

    #[inline(always)]
    fn add_product<X: Unknown<f64>>(
        &self,
        lower: &[f64],
        x: &[X],
        groups: &[Range<usize>],
        y: &mut [X],
    ) {
        for group in groups {
            match group.len() {
                3 => self.multiply_group::<X, 3>(lower, x, group.start, y),
                2 => self.multiply_group::<X, 2>(lower, x, group.start, y),
                _ => self.multiply_group::<X, 1>(lower, x, group.start, y),
            }
        }
    }

    #[inline(always)]
    fn multiply_group<X: Unknown<f64>, const N: usize>(
        &self,
        lower: &[f64],
        x: &[X],
        first: usize,
        y: &mut [X],
    ) {
        let at: [X; N] = std::array::from_fn(|j| x[first + j]);
        let columns: [&[f64]; N] = std::array::from_fn(|j| {
            &lower[self.column_start[first + j]..self.column_start[first + j + 1]]
        });
        let mut sums = [X::zero(); N];
        for j in 0..N {
            sums[j] = sums[j].plus(columns[j][0], at[j]);
            for i in j + 1..N {
                let value = columns[j][i - j];
                sums[i] = sums[i].plus(value, at[j]);
                sums[j] = sums[j].plus(value, at[i]);
            }
        }
        let below = &self.rows[self.column_start[first] + N..self.column_start[first + 1]];
        let columns: [&[f64]; N] = std::array::from_fn(|j| &columns[j][N - j..][..below.len()]);
        for (k, &row) in below.iter().enumerate() {
            let (row, mut added) = (row as usize, X::zero());
            let there = x[row];
            for j in 0..N {
                added = added.plus(columns[j][k], at[j]);
                sums[j] = sums[j].plus(columns[j][k], there);
            }
            y[row] = y[row].plus(1.0, added);
        }
        (0..N).for_each(|j| y[first + j] = y[first + j].plus(1.0, sums[j]));
    }
}

struct AddProduct<'a> {
    triangle: &'a Triangle,
    lower: &'a [f64],
    x: &'a [Row<f64>],
    groups: &'a [Range<usize>],
    y: &'a mut [Row<f64>],
}

impl WithSimd for AddProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.triangle.add_product(self.lower, self.x, self.groups, self.y);
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
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Σ of vectors of one length; of none an empty one.
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
