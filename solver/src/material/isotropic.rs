//! Laws given as ψ(Ī₁, Ī₂, J): stress and tangent by the chain rule.
//!
//! Ī₁ = J^{−2/3} I₁      Ī₂ = J^{−4/3} I₂
//!
//! With B = FFᵀ and dev the deviatoric part, P = τ F⁻ᵀ and
//!
//! τ = 2 ψ₁ J^{−2/3} dev B + 2 ψ₂ J^{−4/3} dev(I₁B − B²) + J ψ_J I
//!
//! dev B = dev(B − I), and likewise for the second term: written so, nothing
//! of order one cancels, and the stress keeps its digits at any strain.
//!
//! Source: Bonet and Wood, "Nonlinear Continuum Mechanics for Finite Element
//! Analysis", chapter on hyperelasticity.

use super::{Kinematics, Material};
use crate::math::remainder::exp_m1_minus;
use crate::math::simd::{Wide, widest};
use crate::math::tensor::{Mat3, Mat9, cross_matrix, vec9};

/// ψ and its derivatives [J/m³] with respect to (Ī₁, Ī₂, J); J does not couple
/// to the others.
pub struct Partials {
    /// ψ.
    pub value: f64,
    /// ∂ψ/∂(Ī₁, Ī₂, J).
    pub first: [f64; 3],
    /// Second derivatives in the order 11, 12, 22, JJ.
    pub second: [f64; 4],
}

/// What the laws of this file depend on.
pub struct Invariants {
    /// Ī₁ − 3.
    pub a: f64,
    /// Ī₂ − 3.
    pub b: f64,
    /// J.
    pub j: f64,
    /// ln J.
    pub log_j: f64,
    /// J − 1.
    pub j_minus_1: f64,
    /// J^{−2/3}.
    ratio: f64,
}

/// An isotropic law; J > 0 is given.
pub trait Isotropic: Send + Sync {
    /// ψ and its derivatives.
    fn partials(&self, at: &Invariants) -> Partials;
    /// Number of parameters.
    fn parameter_count(&self) -> usize;
    /// Adds Σₖ barₖ ∂²ψ/∂(Ī₁, Ī₂, J)ₖ∂parameters.
    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]);
}

impl Invariants {
    /// The invariants of a deformation, to their last digits near rest.
    #[must_use]
    pub fn new(k: &Kinematics) -> Self {
        let log_j = k.log_j();
        let y = -2.0 / 3.0 * log_j;
        let [first, second] = k.excess();
        // r − 1 = eʸ − 1 and e²ʸ − 1, and what of them is beyond first order
        let (e, beyond) = (y.exp_m1(), exp_m1_minus(y));
        let (e2, beyond2) = (e * (2.0 + e), e * e + 2.0 * beyond);
        Self {
            a: first + 3.0 * beyond + k.i1_minus_3() * e,
            b: second + 3.0 * beyond2 + k.i2_minus_3() * e2,
            j: k.j(),
            log_j,
            j_minus_1: k.j_minus_1,
            ratio: 1.0 + e,
        }
    }
}

impl<T: Isotropic> Material for T {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        if k.j() > 0.0 { self.partials(&Invariants::new(k)).value } else { f64::INFINITY }
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        let at = Invariants::new(k);
        let [p1, p2, pj] = self.partials(&at).first;
        let [g1, g2] = gradients(k, &at);
        p1 * g1 + p2 * g2 + pj * k.cofactor
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let at = Invariants::new(k);
        let p = Plain::new(k, &at, &self.partials(&at));
        widest(Tangent { partials: &p, k })
    }

    fn parameter_count(&self) -> usize {
        Isotropic::parameter_count(self)
    }

    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
        let at = Invariants::new(k);
        let [g1, g2] = gradients(k, &at);
        self.add_partials_vjp(&at, [g1.dot(p_bar), g2.dot(p_bar), k.cofactor.dot(p_bar)], out);
    }
}

/// ∂Ī₁/∂F and ∂Ī₂/∂F.
fn gradients(k: &Kinematics, at: &Invariants) -> [Mat3; 2] {
    let g = k.left_minus_1();
    let r = at.ratio;
    // with G = B − I: I₁B − B² = (1 + tr G) G − G² + a multiple of I
    let second = (1.0 + g.trace()) * g - g * g;
    let inverse_transpose = k.cofactor / at.j;
    [
        (2.0 * r) * deviator(&g) * inverse_transpose,
        (2.0 * r * r) * deviator(&second) * inverse_transpose,
    ]
}

fn deviator(a: &Mat3) -> Mat3 {
    a - Mat3::from_diagonal_element(a.trace() / 3.0)
}

/// Derivatives with respect to (I₁, I₂, J); second in the order 11, 12, 22, 1J,
/// 2J, JJ.
struct Plain {
    first: [f64; 3],
    second: [f64; 6],
}

impl Plain {
    fn new(k: &Kinematics, at: &Invariants, p: &Partials) -> Self {
        let (j, r) = (at.j, at.ratio);
        let r2 = r * r;
        let (i1, i2) = (k.i1_minus_3() + 3.0, k.i2_minus_3() + 3.0);
        let [p1, p2, pj] = p.first;
        let [s11, s12, s22, sjj] = p.second;
        // derivatives of Ī₁ and Ī₂ with respect to J, and of ψ₁ and ψ₂
        let (a_j, b_j) = (-2.0 / 3.0 * i1 * r / j, -4.0 / 3.0 * i2 * r2 / j);
        let (a_jj, b_jj) = (10.0 / 9.0 * i1 * r / (j * j), 28.0 / 9.0 * i2 * r2 / (j * j));
        let (p1_j, p2_j) = (s11 * a_j + s12 * b_j, s12 * a_j + s22 * b_j);
        Self {
            first: [p1 * r, p2 * r2, p1 * a_j + p2 * b_j + pj],
            second: [
                s11 * r * r,
                s12 * r * r2,
                s22 * r2 * r2,
                p1_j * r - 2.0 / 3.0 * p1 * r / j,
                p2_j * r2 - 4.0 / 3.0 * p2 * r2 / j,
                p1_j * a_j + p2_j * b_j + p1 * a_jj + p2 * b_jj + sjj,
            ],
        }
    }
}

/// ∂²ψ/∂F² from partial derivatives.
struct Tangent<'a> {
    partials: &'a Plain,
    k: &'a Kinematics,
}

impl Wide for Tangent<'_> {
    type Output = Mat9;

    #[inline(always)]
    fn run(self) -> Mat9 {
        self.partials.tangent(self.k)
    }
}

impl Plain {
    /// ∂²ψ/∂F².
    #[inline(always)]
    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let (g1, g2, gj) = (2.0 * vec9(&k.f), vec9(&i2_gradient(k)), vec9(&k.cofactor));
        let [s11, s12, s22, s1j, s2j, sjj] = self.second;
        let [p1, p2, pj] = self.first;
        // with the term 4 p₂ F ⊗ F of ∂²I₂/∂F²
        let h1 = (s11 + p2) * g1 + s12 * g2 + s1j * gj;
        let h2 = s12 * g1 + s22 * g2 + s2j * gj;
        let hj = s1j * g1 + s2j * g2 + sjj * gj;
        let mut a = g1 * h1.transpose() + g2 * h2.transpose() + gj * hj.transpose();
        for i in 0..9 {
            a[(i, i)] += 2.0 * p1;
        }
        if p2 != 0.0 {
            add_i2_hessian(k, p2, &mut a);
        }
        add_j_hessian(k, pj, &mut a);
        a
    }
}

#[inline(always)]
fn i2_gradient(k: &Kinematics) -> Mat3 {
    // 2(I₁F − FFᵀF)
    2.0 * ((k.i1_minus_3() + 3.0) * k.f - k.f * k.f.transpose() * k.f)
}

/// ∂²I₂/∂F² : H = 2[2(F:H)F + I₁H − HFᵀF − FHᵀF − FFᵀH], without the first
/// term.
#[inline(always)]
fn add_i2_hessian(k: &Kinematics, scale: f64, a: &mut Mat9) {
    let s = 2.0 * scale;
    let i1 = k.i1_minus_3() + 3.0;
    let (b, c) = (k.f * k.f.transpose(), k.f.transpose() * k.f);
    let same = Mat3::from_diagonal_element(s * i1) - s * b;
    for j in 0..3 {
        for l in 0..3 {
            // ∂(column j) / ∂H (column l)
            let mut block = -s * k.f.column(l) * k.f.column(j).transpose();
            let c = s * c[(l, j)];
            for i in 0..3 {
                block[(i, i)] -= c;
            }
            if j == l {
                block += same;
            }
            let mut target = a.fixed_view_mut::<3, 3>(3 * j, 3 * l);
            target += block;
        }
    }
}

/// ∂²J/∂F²: column c of cof F is f_{c+1} × f_{c+2}.
#[inline(always)]
pub(super) fn add_j_hessian(k: &Kinematics, scale: f64, a: &mut Mat9) {
    for c in 0..3 {
        let (c1, c2) = ((c + 1) % 3, (c + 2) % 3);
        let (f1, f2) = (k.f.column(c1).into_owned(), k.f.column(c2).into_owned());
        let mut by_c1 = a.fixed_view_mut::<3, 3>(3 * c, 3 * c1);
        by_c1 -= scale * cross_matrix(&f2);
        let mut by_c2 = a.fixed_view_mut::<3, 3>(3 * c, 3 * c2);
        by_c2 += scale * cross_matrix(&f1);
    }
}
