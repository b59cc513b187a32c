//! Linear elasticity of small displacements.
//!
//! ψ = μ ε:ε + ½λ tr²ε      P = 2με + λ tr ε I      ε = ½(∇u + ∇uᵀ)
//!
//! Source: Ciarlet, "Mathematical Elasticity I", section 6.2.
//! Limits: a rotation strains it. J ≤ 0 counts as inverted, as for all laws.

use super::lame::{self, Lame};
use super::law::Law;
use super::{Kinematics, Material};
use crate::math::tensor::{Mat3, Mat9};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearElastic(pub Lame);

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "linear-elastic",
    formula: "ψ = μ ε:ε + ½ λ tr²ε,  ε = ½ (∇u + ∇uᵀ)",
    parameters: lame::PARAMETERS,
    shear: lame::SHEAR,
    bulk: lame::BULK,
    source: "Ciarlet, Mathematical Elasticity I, section 6.2",
    limits: "for verification: small displacements and rotations only",
    objective: false,
    moduli: lame::moduli,
    build: |p| Box::new(LinearElastic(Lame::new(p[0], p[1]))),
    refuses: |_| None,
    sample: &[1.7e5, 0.3],
};

impl Material for LinearElastic {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        self.0.energy_density(k, &strain(k))
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        self.0.stress(&strain(k))
    }

    fn tangent(&self, _: &Kinematics) -> Mat9 {
        let mut a = Mat9::zeros();
        for i in 0..3 {
            for j in 0..3 {
                a[(3 * j + i, 3 * j + i)] += self.0.mu;
                a[(3 * j + i, 3 * i + j)] += self.0.mu;
                a[(4 * i, 4 * j)] += self.0.lambda;
            }
        }
        a
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
        let strain = strain(k);
        self.0.add_vjp(2.0 * strain.dot(p_bar), strain.trace() * p_bar.trace(), out);
    }
}

/// ε = ½(∇u + ∇uᵀ).
fn strain(k: &Kinematics) -> Mat3 {
    0.5 * (k.grad_u + k.grad_u.transpose())
}
