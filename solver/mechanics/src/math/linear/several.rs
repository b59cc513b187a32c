//! Preconditioned conjugate gradients for several right sides side by side, each with step lengths of its own.
//!
//! Source: Nocedal and Wright, "Numerical Optimization", algorithm 5.3.

use rayon::prelude::*;

use super::matrix::PIECE;
use super::rows::{Row, SYSTEMS};
use super::unknown::Unknown;

/// Rows of a piece by which threads share vectors.
const ROWS: usize = PIECE / SYSTEMS;

/// Solves A X = B from zero, with `multiply` for A, which is positive definite, and `precondition` for an approximate
/// inverse: to the tolerance, as a relative residual of each system, or as far as so many steps come.
pub fn solve_several(
    multiply: impl Fn(&[Row<f64>]) -> Vec<Row<f64>>,
    precondition: impl Fn(&[Row<f64>]) -> Vec<Row<f64>>,
    b: Vec<Row<f64>>,
    (tolerance, steps): (f64, usize),
) -> Vec<Row<f64>> {
    let wanted = dots(&b, &b).0.map(|square| tolerance * tolerance * square);
    let mut open = wanted.map(|square| square > 0.0);
    let mut x = vec![Row([0.0; SYSTEMS]); b.len()];
    let mut r = b;
    let mut p = precondition(&r);
    let mut rz = dots(&r, &p);
    for _ in 0..steps {
        let ap = multiply(&p);
        let curvature = dots(&p, &ap);
        let mut alpha = [0.0; SYSTEMS];
        for k in 0..SYSTEMS {
            open[k] &= curvature.0[k] > 0.0;
            if open[k] {
                alpha[k] = rz.0[k] / curvature.0[k];
            }
        }
        add_scaled(&mut x, alpha, &p);
        add_scaled(&mut r, alpha.map(|a| -a), &ap);
        let left = dots(&r, &r);
        (0..SYSTEMS).for_each(|k| open[k] &= left.0[k] > wanted[k]);
        if !open.contains(&true) {
            break;
        }
        let z = precondition(&r);
        let next = dots(&r, &z);
        let mut beta = [0.0; SYSTEMS];
        for k in (0..SYSTEMS).filter(|&k| open[k]) {
            beta[k] = next.0[k] / rz.0[k];
        }
        let before = std::mem::replace(&mut p, z);
        add_scaled(&mut p, beta, &before);
        rz = next;
    }
    x
}

/// Puts vectors of one length side by side; where they are fewer than [`SYSTEMS`], the others are zero.
pub fn side_by_side(vectors: &[Vec<f64>]) -> Vec<Row<f64>> {
    let mut rows = vec![Row([0.0; SYSTEMS]); vectors[0].len()];
    for (k, vector) in vectors.iter().enumerate() {
        rows.iter_mut().zip(vector).for_each(|(row, &x)| row.0[k] = x);
    }
    rows
}

/// The vector of one system.
pub fn one_of(rows: &[Row<f64>], k: usize) -> Vec<f64> {
    rows.iter().map(|row| row.0[k]).collect()
}

/// y ← y + scale x, with a scale of each system.
fn add_scaled(y: &mut [Row<f64>], scale: [f64; SYSTEMS], x: &[Row<f64>]) {
    let pairs = y.par_iter_mut().zip(x).with_min_len(ROWS);
    pairs.for_each(|(y, x)| (0..SYSTEMS).for_each(|k| y.0[k] += scale[k] * x.0[k]));
}

/// Scalar products, summed up by pieces of constant length, so that they have the same bits for any number of threads.
pub fn dots(x: &[Row<f64>], y: &[Row<f64>]) -> Row<f64> {
    let of_piece = |(x, y): (&[Row<f64>], &[Row<f64>])| {
        let mut sums = Row([0.0; SYSTEMS]);
        for (x, y) in x.iter().zip(y) {
            (0..SYSTEMS).for_each(|k| sums.0[k] += x.0[k] * y.0[k]);
        }
        sums
    };
    let pieces = x.par_chunks(ROWS).zip(y.par_chunks(ROWS));
    let sums: Vec<Row<f64>> = pieces.map(of_piece).collect();
    sums.into_iter().fold(Row([0.0; SYSTEMS]), |sum, piece| sum.plus(1.0, piece))
}
