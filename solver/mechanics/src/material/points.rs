//! Laws given as ψ(Ī₁, Ī₂, J), at points side by side: stress and tangent by the chain rule.
//! One point alone is a single lane, so that its bits are the same.
//!
//! As in [`Kinematics`](super::Kinematics), differences to the rest state are formed from ∇u,
//! so that they keep their digits at small strain.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use pulp::Simd;

use super::{Decoupled, Invariants};
use crate::math::lanes::projection::Tangents;
use crate::math::lanes::tensor::{
    Tensor, cofactor, determinant, plus_identity, product, scaled, trace, transpose,
};
use crate::math::lanes::{Lanes, MOST};

/// Deformations, one in each lane.
pub struct Points<S: Simd> {
    simd: S,
    /// ∇u.
    pub(super) grad_u: Tensor<S>,
    /// F = I + ∇u.
    pub(super) f: Tensor<S>,
    /// cof F.
    pub(super) cofactor: Tensor<S>,
    /// J − 1.
    j_minus_1: Lanes<S>,
    /// J.
    pub(super) j: Lanes<S>,
    /// ln J.
    pub(super) log_j: Lanes<S>,
    /// I₁ − 3 − 2 ln J.
    pub(super) excess: Lanes<S>,
    /// I₁ − 3.
    i1_minus_3: Lanes<S>,
    /// I₂ − 3.
    i2_minus_3: Lanes<S>,
    /// J^{−2/3}.
    ratio: Lanes<S>,
    /// Ī₁ − 3 and Ī₂ − 3.
    isochoric: [Lanes<S>; 2],
}

/// ψ and its derivatives with respect to (Ī₁, Ī₂, J), as in [`super::Partials`].
pub struct Derivatives<S: Simd> {
    first: [Lanes<S>; 3],
    second: [Lanes<S>; 4],
}

impl<S: Simd> Points<S> {
    /// From the displacement gradients ∇u.
    #[inline(always)]
    pub fn new(simd: S, grad_u: &Tensor<S>) -> Self {
        let (h, one) = (grad_u, Lanes::splat(simd, 1.0));
        let f = plus_identity(h, one);
        let j_minus_1 = j_minus_1(h);
        let j = j_minus_1 + 1.0;
        let remainder = j_minus_1.ln_1p_minus();
        let log_j = j_minus_1 + remainder;

        // E = ½(H + Hᵀ + HᵀH) and its invariants
        let green = scaled(&sum(h, &transpose(h), &product(&transpose(h), h)), one * 0.5);
        let minors = cofactor(&green);
        let (first, second) = (trace(&green), trace(&minors));
        let third = determinant(&green, &minors);
        let (i1_minus_3, i2_minus_3) = (first * 2.0, (first + second) * 4.0);

        // J² = 1 + 2 I_E + 4 II_E + 8 III_E. With ln J² − (J² − 1) = 2 (ln J − (J − 1)) − (J − 1)²
        // the terms of first order cancel on paper, not in the computer:
        // I₁ − 3 − 2 ln J and I₂ − 3 − 4 ln J
        let log = remainder * 2.0 - j_minus_1 * j_minus_1;
        let (second, third) = (second * 4.0, third * 8.0);
        let (excess_1, excess_2) = (-log - second - third, log * -2.0 - second - third * 2.0);

        // with r = eʸ: r − 1 and r² − 1, and what of them is beyond first order
        let y = log_j * (-2.0 / 3.0);
        let beyond = y.exp_m1_minus();
        let e = y + beyond;
        let (e2, beyond2) = (e * (e + 2.0), e * e + beyond * 2.0);
        let isochoric =
            [excess_1 + beyond * 3.0 + i1_minus_3 * e, excess_2 + beyond2 * 3.0 + i2_minus_3 * e2];
        let (cofactor, ratio) = (cofactor(&f), e + 1.0);
        Self {
            simd,
            grad_u: *h,
            f,
            cofactor,
            j_minus_1,
            j,
            log_j,
            excess: excess_1,
            i1_minus_3,
            i2_minus_3,
            ratio,
            isochoric,
        }
    }

    /// A number that is the same at all points.
    #[inline(always)]
    pub(super) fn splat(&self, x: f64) -> Lanes<S> {
        Lanes::splat(self.simd, x)
    }

    /// The invariants of each lane.
    #[inline(always)]
    pub fn invariants(&self) -> [Invariants; MOST] {
        let [a, b] = [self.isochoric[0].to_array(), self.isochoric[1].to_array()];
        let (j, log_j) = (self.j.to_array(), self.log_j.to_array());
        let j_minus_1 = self.j_minus_1.to_array();
        let mut at = [Invariants::default(); MOST];
        for lane in 0..Lanes::<S>::COUNT {
            at[lane] = Invariants {
                a: a[lane],
                b: b[lane],
                j: j[lane],
                log_j: log_j[lane],
                j_minus_1: j_minus_1[lane],
            };
        }
        at
    }

    /// ψ of each lane [J/m³].
    #[inline(always)]
    pub fn energy_densities(&self, law: &dyn Decoupled) -> [f64; MOST] {
        let at = self.invariants();
        let mut values = [0.0; MOST];
        for lane in 0..Lanes::<S>::COUNT {
            let admissible = at[lane].j > 0.0;
            values[lane] = if admissible { law.partials(&at[lane]).value } else { f64::INFINITY };
        }
        values
    }

    /// The derivatives of a law.
    #[inline(always)]
    pub fn partials(&self, law: &dyn Decoupled) -> Derivatives<S> {
        let at = self.invariants();
        let (mut first, mut second) = ([[0.0; MOST]; 3], [[0.0; MOST]; 4]);
        for lane in 0..Lanes::<S>::COUNT {
            let p = law.partials(&at[lane]);
            for k in 0..3 {
                first[k][lane] = p.first[k];
            }
            for k in 0..4 {
                second[k][lane] = p.second[k];
            }
        }
        let zero = Lanes::splat(self.simd, 0.0);
        let mut derivatives = Derivatives { first: [zero; 3], second: [zero; 4] };
        for k in 0..3 {
            derivatives.first[k] = Lanes::load(self.simd, &first[k]);
        }
        for k in 0..4 {
            derivatives.second[k] = Lanes::load(self.simd, &second[k]);
        }
        derivatives
    }

    /// These derivatives with the ∂ψ/∂J that was foreseen at another ∇u: p₀ + ∂p₀/∂J cof F₀ : ΔF.
    #[inline(always)]
    pub fn foreseen(
        &self,
        partials: Derivatives<S>,
        law: &dyn Decoupled,
        before: &Tensor<S>,
    ) -> Derivatives<S> {
        let then = j_minus_1(before);
        let (each, log) = (then.to_array(), (then + then.ln_1p_minus()).to_array());
        let mut by = [[0.0; MOST]; 2];
        for lane in 0..Lanes::<S>::COUNT {
            let (j_minus_1, log_j) = (each[lane], log[lane]);
            // J does not couple to the other invariants
            let at = Invariants { a: 0.0, b: 0.0, j: 1.0 + j_minus_1, log_j, j_minus_1 };
            let then = law.partials(&at);
            (by[0][lane], by[1][lane]) = (then.first[2], then.second[3]);
        }
        let [first, second] = by.map(|by| Lanes::load(self.simd, &by));
        let mut partials = partials;
        partials.first[2] = second.mul_add(volume_change(before, &self.grad_u), first);
        partials
    }

    /// 2 dev(G) F⁻ᵀ J^{−2/3} and the like for Ī₂: ∂Ī₁/∂F and ∂Ī₂/∂F.
    #[inline(always)]
    pub fn gradients(&self) -> [Tensor<S>; 2] {
        let [one, two] = self.deviators();
        let [r, r2] = self.factors();
        [product(&scaled(&one, r), &self.cofactor), product(&scaled(&two, r2), &self.cofactor)]
    }

    /// dev G and dev((1 + tr G) G − G²) with G = FFᵀ − I: I₁B − B² but for a multiple of I.
    #[inline(always)]
    fn deviators(&self) -> [Tensor<S>; 2] {
        let g = self.left_minus_1();
        let square = product(&g, &g);
        let mut second = scaled(&g, trace(&g) + 1.0);
        for (s, q) in second.as_flattened_mut().iter_mut().zip(square.as_flattened()) {
            *s -= *q;
        }
        [deviator(&g), deviator(&second)]
    }

    /// FFᵀ − I.
    #[inline(always)]
    pub(super) fn left_minus_1(&self) -> Tensor<S> {
        let h = &self.grad_u;
        sum(h, &transpose(h), &product(h, &transpose(h)))
    }

    /// 2 J^{−2/3} / J and 2 J^{−4/3} / J.
    #[inline(always)]
    fn factors(&self) -> [Lanes<S>; 2] {
        let first = self.ratio * 2.0 / self.j;
        [first, first * self.ratio]
    }

    /// P [Pa].
    #[inline(always)]
    pub fn first_piola(&self, p: &Derivatives<S>) -> Tensor<S> {
        let [one, two] = self.deviators();
        let [r, r2] = self.factors();
        let (p1, p2) = (p.first[0] * r, p.first[1] * r2);
        let mut kirchhoff = one;
        for i in 0..3 {
            for j in 0..3 {
                kirchhoff[i][j] = one[i][j] * p1 + two[i][j] * p2;
            }
            kirchhoff[i][i] += p.first[2];
        }
        product(&kirchhoff, &self.cofactor)
    }

    /// ∂P/∂F [Pa].
    #[inline(always)]
    pub fn tangent(&self, p: &Derivatives<S>) -> Tangents<S> {
        let Plain { first: [p1, p2, pj], second: [s11, s12, s22, s1j, s2j, sjj] } = self.plain(p);
        let g1 = vec9(&scaled(&self.f, Lanes::splat(self.simd, 2.0)));
        let (g2, gj) = (vec9(&self.i2_gradient()), vec9(&self.cofactor));
        let mut a = [[Lanes::splat(self.simd, 0.0); 9]; 9];
        for row in 0..9 {
            // with the term 4 p₂ F ⊗ F of ∂²I₂/∂F²
            let h1 = (s11 + p2) * g1[row] + s12 * g2[row] + s1j * gj[row];
            let h2 = s12 * g1[row] + s22 * g2[row] + s2j * gj[row];
            let hj = s1j * g1[row] + s2j * g2[row] + sjj * gj[row];
            for column in 0..=row {
                a[row][column] = h1 * g1[column] + h2 * g2[column] + hj * gj[column];
            }
            a[row][row] += p1 * 2.0;
        }
        self.add_i2_hessian(p2, &mut a);
        add_j_hessian(&self.f, pj, &mut a);
        a
    }

    /// Derivatives with respect to (I₁, I₂, J).
    #[inline(always)]
    fn plain(&self, p: &Derivatives<S>) -> Plain<S> {
        let (r, over_j) = (self.ratio, self.j.recip());
        let r2 = r * r;
        let (i1, i2) = (self.i1_minus_3 + 3.0, self.i2_minus_3 + 3.0);
        let [p1, p2, pj] = p.first;
        let [s11, s12, s22, sjj] = p.second;
        // derivatives of Ī₁ and Ī₂ with respect to J, and of ψ₁ and ψ₂
        let (a, b) = (i1 * r * over_j, i2 * r2 * over_j);
        let (a_j, b_j) = (a * (-2.0 / 3.0), b * (-4.0 / 3.0));
        let (a_jj, b_jj) = (a * over_j * (10.0 / 9.0), b * over_j * (28.0 / 9.0));
        let (p1_j, p2_j) = (s11 * a_j + s12 * b_j, s12 * a_j + s22 * b_j);
        Plain {
            first: [p1 * r, p2 * r2, p1 * a_j + p2 * b_j + pj],
            second: [
                s11 * r2,
                s12 * r * r2,
                s22 * r2 * r2,
                (p1_j - p1 * over_j * (2.0 / 3.0)) * r,
                (p2_j - p2 * over_j * (4.0 / 3.0)) * r2,
                p1_j * a_j + p2_j * b_j + p1 * a_jj + p2 * b_jj + sjj,
            ],
        }
    }

    /// ∂I₂/∂F = 2 (I₁ F − FFᵀF).
    #[inline(always)]
    fn i2_gradient(&self) -> Tensor<S> {
        let left = product(&self.f, &transpose(&self.f));
        let cubed = product(&left, &self.f);
        let i1 = self.i1_minus_3 + 3.0;
        let mut gradient = cubed;
        for i in 0..3 {
            for j in 0..3 {
                gradient[i][j] = (i1 * self.f[i][j] - cubed[i][j]) * 2.0;
            }
        }
        gradient
    }

    /// ∂²I₂/∂F² : H = 2[2(F:H)F + I₁H − HFᵀF − FHᵀF − FFᵀH], without the first term.
    #[inline(always)]
    fn add_i2_hessian(&self, scale: Lanes<S>, a: &mut Tangents<S>) {
        let (s, f) = (scale * 2.0, &self.f);
        let (left, right) = (product(f, &transpose(f)), product(&transpose(f), f));
        let i1 = s * (self.i1_minus_3 + 3.0);
        for j in 0..3 {
            for l in 0..=j {
                // of component (i, j) by (k, l)
                for i in 0..3 {
                    for k in 0..3 {
                        if 3 * j + i < 3 * l + k {
                            continue;
                        }
                        let mut value = f[i][l] * f[k][j];
                        if i == k {
                            value += right[l][j];
                        }
                        if j == l {
                            value += left[i][k];
                        }
                        a[3 * j + i][3 * l + k] -= s * value;
                    }
                }
                if j == l {
                    for i in 0..3 {
                        a[3 * j + i][3 * j + i] += i1;
                    }
                }
            }
        }
    }
}

/// J − 1 at ∇u = H, without the digits of 1.
#[inline(always)]
pub fn j_minus_1<S: Simd>(h: &Tensor<S>) -> Lanes<S> {
    let minors = cofactor(h);
    trace(h) + (trace(&minors) + determinant(h, &minors))
}

/// The change of J between two ∇u, to first order: cof F : ΔF.
#[inline(always)]
pub fn volume_change<S: Simd>(from: &Tensor<S>, to: &Tensor<S>) -> Lanes<S> {
    let minors = cofactor(&plus_identity(from, from[0][0].zero() + 1.0));
    let mut change = from[0][0].zero();
    for i in 0..3 {
        for j in 0..3 {
            change = minors[i][j].mul_add(to[i][j] - from[i][j], change);
        }
    }
    change
}

/// Adds s ∂²J/∂F²: column c of cof F is f_{c+1} × f_{c+2}.
#[inline(always)]
pub fn add_j_hessian<S: Simd>(f: &Tensor<S>, scale: Lanes<S>, a: &mut Tangents<S>) {
    let f = scaled(f, scale);
    // cof F in columns (1, 0), (2, 0) and (2, 1) by the third column: [±f]ₓ
    for (row, column, third, positive) in [(1, 0, 2, true), (2, 0, 1, false), (2, 1, 0, true)] {
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            // [f]ₓ has −f_{i+2} at (i, i+1) and f_{i+1} at (i, i+2)
            let (low, high) = (f[i2][third], f[i1][third]);
            let (low, high) = if positive { (-low, high) } else { (low, -high) };
            a[3 * row + i][3 * column + i1] += low;
            a[3 * row + i][3 * column + i2] += high;
        }
    }
}

/// Derivatives with respect to (I₁, I₂, J); second in the order 11, 12, 22, 1J, 2J, JJ.
struct Plain<S: Simd> {
    first: [Lanes<S>; 3],
    second: [Lanes<S>; 6],
}

/// a + b + c.
#[inline(always)]
fn sum<S: Simd>(a: &Tensor<S>, b: &Tensor<S>, c: &Tensor<S>) -> Tensor<S> {
    let mut s = *a;
    for i in 0..3 {
        for j in 0..3 {
            s[i][j] = a[i][j] + b[i][j] + c[i][j];
        }
    }
    s
}

#[inline(always)]
fn deviator<S: Simd>(a: &Tensor<S>) -> Tensor<S> {
    plus_identity(a, trace(a) * (-1.0 / 3.0))
}

/// Column-major `vec`.
#[inline(always)]
pub(super) fn vec9<S: Simd>(a: &Tensor<S>) -> [Lanes<S>; 9] {
    let mut v = [a[0][0]; 9];
    for j in 0..3 {
        for i in 0..3 {
            v[3 * j + i] = a[i][j];
        }
    }
    v
}
