//! Compressible neo-Hookean law.
//!
//! ψ = ½μ(I₁ − 3 − 2 ln J) + ½λ ln²J
//! P = τ F⁻ᵀ      τ = μ(FFᵀ − I) + λ ln J I
//!
//! Source: Bonet and Wood, "Nonlinear Continuum Mechanics for Finite Element
//! Analysis", section on compressible neo-Hookean material.

use pulp::Simd;

use super::decoupled::alone;
use super::lame::{self, Lame};
use super::law::Law;
use super::points::{self, Points, vec9};
use super::{Decoupled, Invariants, Isochoric, Kinematics, Material, Partials, Split};
use crate::math::lanes::projection::Tangents;
use crate::math::lanes::tensor::{Tensor, lane, plus_identity, product, scaled};
use crate::math::lanes::{Lanes, MOST};
use crate::math::tensor::{Mat3, Mat9};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean(pub Lame);

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "neo-hookean",
    formula: "ψ = ½ μ (I1 − 3 − 2 ln J) + ½ λ ln²J",
    parameters: lame::PARAMETERS,
    shear: lame::SHEAR,
    bulk: lame::BULK,
    source: "Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis; \
             μ, λ: Lamé's parameters in space (not plane stress)",
    limits: "no stiffening: fits silicone to about twice its length",
    objective: true,
    moduli: lame::moduli,
    build: |p| Box::new(NeoHookean(Lame::new(p[0], p[1]))),
    refuses: |_| None,
    sample: &[1e5, 0.35],
};

impl Material for NeoHookean {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        self.energy_densities(&alone(k))[0]
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        lane(&self.stresses(&alone(k)), 0)
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let a = self.tangents(&alone(k), None);
        Mat9::from_fn(|i, j| a[i.max(j)][i.min(j)].to_array()[0])
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
        let [by_mu, by_lambda] = by_lame(k);
        self.0.add_vjp(by_mu.dot(p_bar), by_lambda.dot(p_bar), out);
    }

    fn neo_hookean(&self) -> Option<&NeoHookean> {
        Some(self)
    }

    fn isochoric(&self) -> Option<Isochoric> {
        Some(Isochoric::new(Shear(self.0)))
    }

    fn split(&self) -> Option<Split> {
        Some(Split::by_difference(*self, Volume(self.0)))
    }
}

/// At points side by side.
impl NeoHookean {
    /// ψ of each lane [J/m³].
    #[inline(always)]
    pub fn energy_densities<S: Simd>(&self, at: &Points<S>) -> [f64; MOST] {
        let Lame { mu, lambda, .. } = self.0;
        let value = at.excess * (0.5 * mu) + at.log_j * at.log_j * (0.5 * lambda);
        at.j.if_positive(value, at.splat(f64::INFINITY)).to_array()
    }

    /// P [Pa].
    #[inline(always)]
    pub fn stresses<S: Simd>(&self, at: &Points<S>) -> Tensor<S> {
        let Lame { mu, lambda, .. } = self.0;
        let kirchhoff = plus_identity(&scaled(&at.left_minus_1(), at.splat(mu)), at.log_j * lambda);
        product(&kirchhoff, &scaled(&at.cofactor, at.j.recip()))
    }

    /// ∂P/∂F [Pa], the lower triangle. With T = F⁻ᵀ: A = μ 1 + λ T⊗T + (λ ln J − μ) ∂T/∂F, and
    /// ∂T/∂F = (∂²J/∂F²)/J − T⊗T. The factor p = (λ ln J − μ)/J of ∂²J/∂F² may be that which was foreseen at another ∇u.
    #[inline(always)]
    pub fn tangents<S: Simd>(&self, at: &Points<S>, before: Option<&Tensor<S>>) -> Tangents<S> {
        let Lame { mu, lambda, .. } = self.0;
        let over_j = at.j.recip();
        let t = vec9(&scaled(&at.cofactor, over_j));
        let by_inverse = at.log_j * lambda - mu;
        let both = -by_inverse + lambda;
        let mut a = [[at.splat(0.0); 9]; 9];
        for row in 0..9 {
            let own = both * t[row];
            for column in 0..=row {
                a[row][column] = own * t[column];
            }
            a[row][row] += at.splat(mu);
        }
        let pressure = match before {
            Some(before) => self.foreseen(at, before),
            None => by_inverse * over_j,
        };
        points::add_j_hessian(&at.f, pressure, &mut a);
        a
    }

    /// p₀ + ∂p₀/∂J cof F₀ : ΔF [Pa], from another ∇u.
    #[inline(always)]
    fn foreseen<S: Simd>(&self, at: &Points<S>, before: &Tensor<S>) -> Lanes<S> {
        let Lame { mu, lambda, .. } = self.0;
        let j_minus_1 = points::j_minus_1(before);
        let (log_j, over_j) = (j_minus_1 + j_minus_1.ln_1p_minus(), (j_minus_1 + 1.0).recip());
        let first = (log_j * lambda - mu) * over_j;
        let second = (over_j * lambda - first) * over_j;
        second.mul_add(points::volume_change(before, &at.grad_u), first)
    }
}

/// ½μ(Ī₁ − 3), what is left of the law where J = 1.
#[derive(Clone)]
struct Shear(Lame);

impl Decoupled for Shear {
    fn partials(&self, at: &Invariants) -> Partials {
        let half = 0.5 * self.0.mu;
        Partials { value: half * at.a, first: [half, 0.0, 0.0], second: [0.0; 4] }
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        self.0.add_vjp(0.5 * at.a * bar, 0.0, out);
    }

    fn add_partials_vjp(&self, _: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        self.0.add_vjp(0.5 * bar[0], 0.0, out);
    }
}

/// ½λ ln²J.
#[derive(Clone)]
struct Volume(Lame);

impl Decoupled for Volume {
    fn partials(&self, at: &Invariants) -> Partials {
        Partials::half_log_squared(self.0.lambda, at)
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        self.0.add_vjp(0.0, 0.5 * at.log_j * at.log_j * bar, out);
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        self.0.add_vjp(0.0, at.log_j / at.j * bar[2], out);
    }
}

/// ∂P/∂μ and ∂P/∂λ.
fn by_lame(k: &Kinematics) -> [Mat3; 2] {
    let inverse_transpose = k.cofactor / k.j();
    [k.left_minus_1() * inverse_transpose, k.log_j() * inverse_transpose]
}
