//! Incompressible neo-Hookean sheet in plane stress, for films and rings of rubber.
//!
//! ψ = ½ mu (tr C + 1/det C − 3)      C = I + 2E
//! S = mu (I − cof C/det²C)           cof C = det C · C⁻¹
//! D = 4 mu/det³C cof C ⊗ cof C − 2 mu/det²C ∂cof E/∂E
//!
//! 1/√det C is the stretch of the thickness. With det C = 1 + d, d = 2 tr E + 4 det E, all terms
//! of first order in ψ cancel on paper, and those that are left keep their digits:
//! ψ = ½ mu (d²/(1 + d) − 4 det E), S = mu/(1 + d)² (d (2 + d) I − 2 cof E).
//! Under uniaxial stress C₂ = 1/√C₁.
//!
//! Source: Holzapfel, "Nonlinear Solid Mechanics", section 6.5.

use super::{Sheet, Strain, Stress};
use crate::material::law::{Law, Moduli, PA, Parameter};
use crate::math::tensor::Mat3;

/// Parameter of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Shear modulus [Pa].
    pub mu: f64,
}

/// The row of the table.
pub(super) const LAW: Law<dyn Sheet> = Law {
    key: "neo-hookean",
    formula: "ψ = ½ mu (tr C + 1/det C − 3),  C = I + 2E",
    parameters: &[Parameter::one("mu", PA, "shear modulus at rest")],
    shear: "mu",
    bulk: "3 mu of area",
    source: "Holzapfel, Nonlinear Solid Mechanics, section 6.5, at constant volume and without \
             stress across the sheet",
    limits: "rubber to about twice its length, no stiffening; without bending stiffness, so that it \
             buckles in compression unless what it is bonded to holds it",
    objective: true,
    moduli: |p| Moduli { shear: p[0], bulk: 3.0 * p[0] },
    build: |p| Box::new(NeoHookean { mu: p[0] }),
    refuses: |_| None,
    sample: &[3.2e4],
};

/// det E.
fn determinant(e: &Strain) -> f64 {
    e[0] * e[1] - 0.25 * e[2] * e[2]
}

/// cof E, as a stress.
fn cofactor(e: &Strain) -> Stress {
    Stress::new(e[1], e[0], -0.5 * e[2])
}

/// d = det C − 1.
fn growth(e: &Strain) -> f64 {
    2.0 * (e[0] + e[1]) + 4.0 * determinant(e)
}

/// S/mu.
fn shape(e: &Strain) -> Stress {
    let d = growth(e);
    let own = d * (2.0 + d);
    (Stress::new(own, own, 0.0) - 2.0 * cofactor(e)) / (1.0 + d).powi(2)
}

impl Sheet for NeoHookean {
    /// Infinite where the sheet has no area left.
    fn energy_density(&self, e: &Strain) -> f64 {
        let d = growth(e);
        if d <= -1.0 {
            return f64::INFINITY;
        }
        0.5 * self.mu * (d * d / (1.0 + d) - 4.0 * determinant(e))
    }

    fn stress(&self, e: &Strain) -> Stress {
        self.mu * shape(e)
    }

    fn tangent(&self, e: &Strain) -> Mat3 {
        let det = 1.0 + growth(e);
        let cof = Stress::new(1.0, 1.0, 0.0) + 2.0 * cofactor(e);
        let by_cofactor = Mat3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -0.5);
        self.mu * (4.0 / det.powi(3) * cof * cof.transpose() - 2.0 / det.powi(2) * by_cofactor)
    }

    fn parameters(&self) -> &'static [Parameter] {
        LAW.parameters
    }

    fn add_parameter_vjp(&self, e: &Strain, s_bar: &Strain, out: &mut [f64]) {
        out[0] += shape(e).dot(s_bar);
    }

    /// ½ (C₁^{−½} − 1), with the digits of a small E₁.
    fn natural_width(&self, stretched: f64) -> f64 {
        let root = (1.0 + 2.0 * stretched).sqrt();
        -stretched / (root * (1.0 + root))
    }
}
