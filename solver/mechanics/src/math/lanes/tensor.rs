//! 3×3 tensors in lanes.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use pulp::Simd;

use super::Lanes;
use crate::math::tensor::Mat3;

/// A 3×3 tensor in each lane; `[i][j]` is row i, column j.
pub type Tensor<S> = [[Lanes<S>; 3]; 3];

/// A tensor that is the same in all lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, a: &Mat3) -> Tensor<S> {
    let mut t = [[Lanes::splat(simd, 0.0); 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            t[i][j] = Lanes::splat(simd, a[(i, j)]);
        }
    }
    t
}

/// The tensor of one lane.
#[inline(always)]
pub fn lane<S: Simd>(a: &Tensor<S>, lane: usize) -> Mat3 {
    let mut m = Mat3::zeros();
    for i in 0..3 {
        for j in 0..3 {
            m[(i, j)] = a[i][j].to_array()[lane];
        }
    }
    m
}

/// a · b.
#[inline(always)]
pub fn product<S: Simd>(a: &Tensor<S>, b: &Tensor<S>) -> Tensor<S> {
    let mut c = *a;
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        }
    }
    c
}

/// Aᵀ.
#[inline(always)]
pub fn transpose<S: Simd>(a: &Tensor<S>) -> Tensor<S> {
    let mut t = *a;
    for i in 0..3 {
        for j in 0..3 {
            t[i][j] = a[j][i];
        }
    }
    t
}

/// cof A = det(A) A⁻ᵀ.
#[inline(always)]
pub fn cofactor<S: Simd>(a: &Tensor<S>) -> Tensor<S> {
    let mut c = *a;
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            c[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
        }
    }
    c
}

/// det A, with its cofactor.
#[inline(always)]
pub fn determinant<S: Simd>(a: &Tensor<S>, cofactor: &Tensor<S>) -> Lanes<S> {
    a[0][0] * cofactor[0][0] + a[0][1] * cofactor[0][1] + a[0][2] * cofactor[0][2]
}

/// tr A.
#[inline(always)]
pub fn trace<S: Simd>(a: &Tensor<S>) -> Lanes<S> {
    a[0][0] + a[1][1] + a[2][2]
}

/// A + x I.
#[inline(always)]
pub fn plus_identity<S: Simd>(a: &Tensor<S>, x: Lanes<S>) -> Tensor<S> {
    let mut b = *a;
    for (i, row) in b.iter_mut().enumerate() {
        row[i] += x;
    }
    b
}

/// x A.
#[inline(always)]
pub fn scaled<S: Simd>(a: &Tensor<S>, x: Lanes<S>) -> Tensor<S> {
    let mut b = *a;
    for b in b.as_flattened_mut() {
        *b = *b * x;
    }
    b
}
