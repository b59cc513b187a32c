//! Sums, differences and products of vectors of variables and of states.

use mechanics::math::linear::dot;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Numbers of a vector in a piece.
const PIECE: usize = 1024;

/// θ + t d.
pub fn along(theta: &[f64], d: &[f64], t: f64) -> Vec<f64> {
    theta.iter().zip(d).map(|(theta, d)| theta + t * d).collect()
}

/// θ with one variable moved.
pub fn moved(theta: &[f64], i: usize, by: f64) -> Vec<f64> {
    let mut theta = theta.to_vec();
    theta[i] += by;
    theta
}

/// a − b.
pub fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// aᵢ · bⱼ, by pieces of all vectors that stay in the cache.
pub fn products(a: &[Vec<f64>], b: &[Vec<f64>]) -> DMatrix<f64> {
    let length = a.first().map_or(0, Vec::len);
    let starts: Vec<usize> = (0..length).step_by(PIECE).collect();
    let of_piece = |&start: &usize| {
        let piece = start..length.min(start + PIECE);
        DMatrix::from_fn(a.len(), b.len(), |i, j| dot(&a[i][piece.clone()], &b[j][piece.clone()]))
    };
    // a constant order of the sums gives the same bits for any number of threads
    let parts: Vec<DMatrix<f64>> = starts.par_iter().map(of_piece).collect();
    parts.into_iter().fold(DMatrix::zeros(a.len(), b.len()), |sum, part| sum + part)
}
