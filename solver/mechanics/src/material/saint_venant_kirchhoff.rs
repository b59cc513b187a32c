//! Saint-Venant–Kirchhoff law: linear between Green strain and its stress.
//!
//! ψ = μ E:E + ½λ tr²E      P = F(2μE + λ tr E I)      E = ½(FᵀF − I)
//!
//! Source: Ciarlet, "Mathematical Elasticity I", section 3.9.
//! Limits: large rotations, small strains; it softens under compression, down
//! to no stress at all at J = 0.

use super::lame::{self, Lame};
use super::law::Law;
use super::{Kinematics, Material};
use crate::math::tensor::{Mat3, Mat9, vec9};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaintVenantKirchhoff(pub Lame);

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "saint-venant-kirchhoff",
    formula: "ψ = μ E:E + ½ λ tr²E,  E = ½ (FᵀF − I)",
    parameters: lame::PARAMETERS,
    shear: lame::SHEAR,
    bulk: lame::BULK,
    source: "Ciarlet, Mathematical Elasticity I, section 3.9",
    limits: "for verification: unstable under strong compression",
    objective: true,
    moduli: lame::moduli,
    build: |p| Box::new(SaintVenantKirchhoff(Lame::new(p[0], p[1]))),
    refuses: |_| None,
    sample: &[2.1e5, 0.4],
};

impl Material for SaintVenantKirchhoff {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        self.0.energy_density(k, &k.green)
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        k.f * self.0.stress(&k.green)
    }

    /// A : H = H S + μ F(FᵀH + HᵀF) + λ (F:H) F.
    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let (s, b) = (self.0.stress(&k.green), k.f * k.f.transpose());
        let Lame { mu, lambda, .. } = self.0;
        let f = vec9(&k.f);
        let mut a = lambda * f * f.transpose();
        for j in 0..3 {
            for i in 0..3 {
                let row = 3 * j + i;
                for m in 0..3 {
                    a[(row, 3 * m + i)] += s[(m, j)];
                    a[(row, 3 * j + m)] += mu * b[(i, m)];
                    for l in 0..3 {
                        a[(row, 3 * l + m)] += mu * k.f[(i, l)] * k.f[(m, j)];
                    }
                }
            }
        }
        a
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
        let by_mu = 2.0 * k.f * k.green;
        let by_lambda = k.green.trace() * k.f;
        self.0.add_vjp(by_mu.dot(p_bar), by_lambda.dot(p_bar), out);
    }
}
