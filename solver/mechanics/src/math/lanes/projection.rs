//! Tangents of isotropic bodies in lanes, made positive semidefinite where they are not.
//!
//! With F = U Σ Vᵀ the tangent ∂P/∂F has, in the basis u_i v_jᵀ, a block for the three
//! stretches u_i v_iᵀ and one for each pair u_i v_jᵀ, u_j v_iᵀ.
//!
//! Sources: Smith, de Goes and Kim 2019, "Analytic eigensystems for isotropic distortion
//! energies", doi:10.1145/3241041; Jacobi's method: Golub and Van Loan, "Matrix
//! Computations", section 8.5.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use pulp::Simd;

use super::Lanes;
use super::tensor::{Tensor, product, transpose};

/// Lower triangle of a fourth-order tensor ∂P/∂F; index 3·j + i is component (i, j).
pub type Tangents<S> = [[Lanes<S>; 9]; 9];

/// Sweeps of Jacobi's method. It converges quadratically: the fourth has nothing to do
/// beyond rounding.
const SWEEPS: usize = 4;
/// Smallest divisor, where numbers are zero.
const TINY: f64 = 1e-290;

/// The smallest pivot of L D Lᵀ; positive where a tangent is positive definite.
#[inline(always)]
pub fn smallest_pivots<S: Simd>(tangents: &Tangents<S>) -> Lanes<S> {
    let mut a = *tangents;
    let mut smallest = a[0][0];
    for k in 0..9 {
        smallest = smallest.min(a[k][k]);
        let inverse = a[k][k].recip();
        for i in k + 1..9 {
            let l = -(a[i][k] * inverse);
            for j in k + 1..=i {
                a[i][j] = l.mul_add(a[j][k], a[i][j]);
            }
        }
    }
    smallest
}

/// Makes tangents at F positive semidefinite in the lanes whose pivots are not positive: the
/// nearest ones in the Frobenius norm.
#[inline(always)]
pub fn project_isotropic<S: Simd>(tangents: &mut Tangents<S>, f: &Tensor<S>, pivots: Lanes<S>) {
    let zero = pivots.zero();
    let gate = pivots.if_positive(zero, zero + 1.0);
    let (u, v) = singular_vectors(f);
    let stretches = [dyad(&u, &v, 0, 0), dyad(&u, &v, 1, 1), dyad(&u, &v, 2, 2)];
    let lift = lift_3(&block(tangents, &stretches), gate);
    // the blocks of a tangent do not couple, nor what is added to one with another
    add(tangents, &stretches, &lift);
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let pair = [dyad(&u, &v, i, j), dyad(&u, &v, j, i)];
        let lift = lift_2(&block(tangents, &pair), gate);
        add(tangents, &pair, &lift);
    }
}

/// U and V of F = U Σ Vᵀ, J > 0.
#[inline(always)]
fn singular_vectors<S: Simd>(f: &Tensor<S>) -> (Tensor<S>, Tensor<S>) {
    let (_, v) = eigen(product(&transpose(f), f));
    let mut u = product(f, &v);
    for j in 0..3 {
        let square = u[0][j] * u[0][j] + u[1][j] * u[1][j] + u[2][j] * u[2][j];
        let inverse = square.sqrt().recip();
        for row in &mut u {
            row[j] = row[j] * inverse;
        }
    }
    (u, v)
}

/// Column-major `vec` of u_i v_jᵀ.
#[inline(always)]
fn dyad<S: Simd>(u: &Tensor<S>, v: &Tensor<S>, i: usize, j: usize) -> [Lanes<S>; 9] {
    let mut b = [u[0][0]; 9];
    for column in 0..3 {
        for row in 0..3 {
            b[3 * column + row] = u[row][i] * v[column][j];
        }
    }
    b
}

/// The block of a tangent on some basis vectors.
#[inline(always)]
fn block<S: Simd, const N: usize>(
    tangents: &Tangents<S>,
    basis: &[[Lanes<S>; 9]; N],
) -> [[Lanes<S>; N]; N] {
    let zero = basis[0][0].zero();
    let mut block = [[zero; N]; N];
    for k in 0..N {
        let mut image = [zero; 9];
        for (i, image) in image.iter_mut().enumerate() {
            for j in 0..9 {
                *image = tangents[i.max(j)][i.min(j)].mul_add(basis[k][j], *image);
            }
        }
        for l in 0..=k {
            let mut sum = zero;
            for i in 0..9 {
                sum = basis[l][i].mul_add(image[i], sum);
            }
            (block[k][l], block[l][k]) = (sum, sum);
        }
    }
    block
}

/// Adds Σ lift_kl b_k b_lᵀ.
#[inline(always)]
fn add<S: Simd, const N: usize>(
    tangents: &mut Tangents<S>,
    basis: &[[Lanes<S>; 9]; N],
    lift: &[[Lanes<S>; N]; N],
) {
    for l in 0..N {
        for i in 0..9 {
            let mut row = basis[0][i] * lift[0][l];
            for k in 1..N {
                row = basis[k][i].mul_add(lift[k][l], row);
            }
            for j in 0..=i {
                tangents[i][j] = row.mul_add(basis[l][j], tangents[i][j]);
            }
        }
    }
}

/// What makes a symmetric 3×3 block positive semidefinite, times the gate.
#[inline(always)]
fn lift_3<S: Simd>(block: &Tensor<S>, gate: Lanes<S>) -> Tensor<S> {
    let (values, q) = eigen(*block);
    let zero = gate.zero();
    let mut lift = [[zero; 3]; 3];
    for k in 0..3 {
        let by = -(values[k].min(zero) * gate);
        for i in 0..3 {
            for j in 0..3 {
                lift[i][j] = (by * q[i][k]).mul_add(q[j][k], lift[i][j]);
            }
        }
    }
    lift
}

/// What makes a symmetric 2×2 block M with the eigenvalues m ± s positive semidefinite, times
/// the gate: the projectors are (M − (m ∓ s) I) / ±2s.
#[inline(always)]
fn lift_2<S: Simd>(block: &[[Lanes<S>; 2]; 2], gate: Lanes<S>) -> [[Lanes<S>; 2]; 2] {
    let [[a, b], [_, c]] = *block;
    let (m, d) = ((a + c) * 0.5, (a - c) * 0.5);
    let s = (d * d + b * b).sqrt() + TINY;
    let zero = gate.zero();
    let scale = gate * (s * 2.0).recip();
    let (low, high) = ((m - s).min(zero) * scale, (m + s).min(zero) * scale);
    // M − (m − s) I has d + s and −d + s on its diagonal, (m + s) I − M has s − d and s + d
    let (plus, minus) = (s + d, s - d);
    let beside = (low - high) * b;
    [[-(high * plus) - low * minus, beside], [beside, -(high * minus) - low * plus]]
}

/// Eigenvalues of symmetric tensors, and their vectors in columns.
#[inline(always)]
fn eigen<S: Simd>(mut a: Tensor<S>) -> ([Lanes<S>; 3], Tensor<S>) {
    let zero = a[0][0].zero();
    let one = zero + 1.0;
    let mut q = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    for _ in 0..SWEEPS {
        for (i, j, k) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let d = a[j][j] - a[i][i];
            let twice = a[i][j] * 2.0;
            let size = twice / (d.abs() + (d * d + twice * twice).sqrt() + TINY);
            let t = d.if_positive(size, -size);
            let c = (t * t + 1.0).sqrt().recip();
            let s = t * c;
            a[i][i] -= t * a[i][j];
            a[j][j] += t * a[i][j];
            let (x, y) = (a[i][k], a[j][k]);
            (a[i][k], a[j][k]) = (c * x - s * y, s * x + c * y);
            (a[k][i], a[k][j]) = (a[i][k], a[j][k]);
            (a[i][j], a[j][i]) = (zero, zero);
            for row in &mut q {
                (row[i], row[j]) = (c * row[i] - s * row[j], s * row[i] + c * row[j]);
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], q)
}
