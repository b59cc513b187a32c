//! Lamé's parameters from Young's modulus and Poisson's ratio.
//!
//! μ = E/(2(1 + ν))      λ = Eν/((1 + ν)(1 − 2ν))
//!
//! Shared by the laws that are linear in μ and λ.

use super::Kinematics;
use super::law::{Moduli, PA, Parameter};
use crate::math::tensor::Mat3;

/// μ and λ [Pa] and what they came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// Young's modulus E [Pa].
    pub young: f64,
    /// Poisson's ratio ν [1].
    pub poisson: f64,
    /// Shear modulus μ [Pa].
    pub mu: f64,
    /// First parameter λ [Pa].
    pub lambda: f64,
}

/// The parameters of such a law.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::one("young", PA, "Young's modulus E at rest"),
    Parameter::one("poisson", "1", "Poisson's ratio ν at rest"),
];

/// Formula of the shear modulus.
pub(super) const SHEAR: &str = "μ = young / (2 (1 + poisson))";

/// Formula of the bulk modulus.
pub(super) const BULK: &str = "λ + 2/3 μ = young / (3 (1 − 2 poisson))";

impl Lame {
    /// From E and ν.
    pub fn new(young: f64, poisson: f64) -> Self {
        let mu = young / (2.0 * (1.0 + poisson));
        let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        Self { young, poisson, mu, lambda }
    }

    /// μ ε:ε + ½λ tr²ε of a strain [J/m³]; infinite where J is not positive.
    pub(super) fn energy_density(&self, k: &Kinematics, strain: &Mat3) -> f64 {
        if k.j() <= 0.0 {
            return f64::INFINITY;
        }
        let trace = strain.trace();
        self.mu * strain.norm_squared() + 0.5 * self.lambda * trace * trace
    }

    /// 2με + λ tr ε I [Pa].
    pub(super) fn stress(&self, strain: &Mat3) -> Mat3 {
        2.0 * self.mu * strain + Mat3::from_diagonal_element(self.lambda * strain.trace())
    }

    /// Adds (∂(μ, λ)/∂(E, ν))ᵀ (μ̄, λ̄).
    pub(super) fn add_vjp(&self, mu_bar: f64, lambda_bar: f64, out: &mut [f64]) {
        let (e, nu) = (self.young, self.poisson);
        let d = (1.0 + nu) * (1.0 - 2.0 * nu);
        out[0] += (mu_bar * self.mu + lambda_bar * self.lambda) / e;
        out[1] += lambda_bar * e * (1.0 + 2.0 * nu * nu) / (d * d)
            - mu_bar * e / (2.0 * (1.0 + nu) * (1.0 + nu));
    }
}

/// Shear and bulk modulus of [E, ν].
pub(super) fn moduli(p: &[f64]) -> Moduli {
    Moduli { shear: p[0] / (2.0 * (1.0 + p[1])), bulk: p[0] / (3.0 * (1.0 - 2.0 * p[1])) }
}
