//! Laws given as ψ̄(Ī₁, Ī₂) + U(J), of which the isochoric and the volumetric part are decoupled: stress and tangent by
//! the chain rule.
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

use super::points::Points;
use super::{Isochoric, Kinematics, Material, Split};
use crate::math::lanes::Scalar;
use crate::math::lanes::tensor::{lane, splat};
use crate::math::tensor::{Mat3, Mat9};

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

impl Partials {
    /// Those of ½ k ln²J.
    pub(super) fn half_log_squared(k: f64, at: &Invariants) -> Self {
        let (log_j, j) = (at.log_j, at.j);
        Self {
            value: 0.5 * k * log_j * log_j,
            first: [0.0, 0.0, k * log_j / j],
            second: [0.0, 0.0, 0.0, k * (1.0 - log_j) / (j * j)],
        }
    }

    /// These of a volumetric term with the value and the derivatives of an isochoric one.
    pub(super) fn with(self, value: f64, [by_1, by_2]: [f64; 2], [a, b, c]: [f64; 3]) -> Self {
        let (first, second) = ([by_1, by_2, self.first[2]], [a, b, c, self.second[3]]);
        Self { value: value + self.value, first, second }
    }
}

/// What the laws of this file depend on.
#[derive(Clone, Copy, Default)]
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
}

/// An isotropic law ψ̄(Ī₁, Ī₂) + U(J) of decoupled isochoric and volumetric parts; J > 0 is given.
pub trait Decoupled: Send + Sync {
    /// ψ and its derivatives.
    fn partials(&self, at: &Invariants) -> Partials;
    /// Number of parameters.
    fn parameter_count(&self) -> usize;
    /// Adds bar ∂ψ/∂parameters.
    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]);
    /// Adds Σₖ barₖ ∂²ψ/∂(Ī₁, Ī₂, J)ₖ∂parameters.
    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]);
}

/// At a point alone.
pub(super) fn alone(k: &Kinematics) -> Points<Scalar> {
    Points::new(Scalar, &splat(Scalar, &k.grad_u))
}

// Of any law, and so compiled here and once, not where a law is chosen.

fn energy_density(law: &dyn Decoupled, k: &Kinematics) -> f64 {
    let at = Points::invariants(&alone(k))[0];
    if at.j > 0.0 { law.partials(&at).value } else { f64::INFINITY }
}

fn first_piola(law: &dyn Decoupled, k: &Kinematics) -> Mat3 {
    let at = alone(k);
    lane(&at.first_piola(&at.partials(law)), 0)
}

fn tangent(law: &dyn Decoupled, k: &Kinematics) -> Mat9 {
    let at = alone(k);
    let a = at.tangent(&at.partials(law));
    Mat9::from_fn(|i, j| a[i.max(j)][i.min(j)].to_array()[0])
}

fn add_parameter_vjp(law: &dyn Decoupled, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
    let at = alone(k);
    let [by_1, by_2] = at.gradients();
    let bar = [lane(&by_1, 0).dot(p_bar), lane(&by_2, 0).dot(p_bar), k.cofactor.dot(p_bar)];
    law.add_partials_vjp(&at.invariants()[0], bar, out);
}

impl<T: Decoupled + Clone + 'static> Material for T {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        energy_density(self, k)
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        first_piola(self, k)
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        tangent(self, k)
    }

    fn parameter_count(&self) -> usize {
        Decoupled::parameter_count(self)
    }

    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
        add_parameter_vjp(self, k, p_bar, out);
    }

    fn decoupled(&self) -> Option<&dyn Decoupled> {
        Some(self)
    }

    fn isochoric(&self) -> Option<Isochoric> {
        Some(Isochoric::new(self.clone()))
    }

    /// J does not couple to the other invariants.
    fn split(&self) -> Option<Split> {
        Some(Split::of_decoupled(self.clone()))
    }
}
