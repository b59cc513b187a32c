//! Linear between Green strain and its stress: the plane-stress form of the
//! Saint-Venant–Kirchhoff law, for paper, fabric and foils in any rotation.
//!
//! ψ = ½ Ē [ν tr²E + (1 − ν) E:E]      S = Ē [ν tr E I + (1 − ν) E]      Ē = young/(1 − ν²)
//!
//! ν = poisson. It is ψ of the law in three dimensions at the E₃₃ = −ν/(1 − ν) tr E at which
//! S₃₃ = 0. Under uniaxial stress E₂ = −ν E₁ and S₁ = young E₁.
//!
//! Source: Ciarlet, "Mathematical Elasticity I", section 3.9; plane stress: Timoshenko and
//! Woinowsky-Krieger, "Theory of Plates and Shells", section 21.

use super::{Sheet, Strain, Stress};
use crate::material::law::{Law, Moduli, PA, Parameter};
use crate::math::tensor::Mat3;

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Young's modulus [Pa].
    pub young: f64,
    /// Poisson's ratio ν [1].
    pub poisson: f64,
}

/// The row of the table.
pub(super) const LAW: Law<dyn Sheet> = Law {
    key: "sheet",
    formula: "ψ = ½ young/(1 − ν²) [ν tr²E + (1 − ν) E:E],  ν = poisson",
    parameters: &[
        Parameter::one("young", PA, "Young's modulus in the plane"),
        Parameter::one("poisson", "1", "Poisson's ratio ν in the plane, between −1 and 1"),
    ],
    shear: "young / (2 (1 + poisson))",
    bulk: "young / (2 (1 − poisson)) of area",
    source: "plane stress of Saint-Venant and Kirchhoff: Ciarlet, Mathematical Elasticity I, \
             section 3.9",
    limits: "paper, fabric, foils: small strains in any rotation. Isotropic: a weave along its \
             threads only. In compression it is as stiff as in tension although a real sheet \
             buckles or wrinkles, unless tension = true; shorter than 0.58 of its length it softens",
    objective: true,
    moduli: |p| Moduli { shear: p[0] / (2.0 * (1.0 + p[1])), bulk: p[0] / (2.0 * (1.0 - p[1])) },
    build: |p| Box::new(Linear { young: p[0], poisson: p[1] }),
    refuses: |_| None,
    sample: &[2.1e5, 0.3],
};

impl Linear {
    /// Ē.
    fn plane(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }

    /// S/Ē.
    fn shape(&self, e: &Strain) -> Stress {
        let (nu, trace) = (self.poisson, e[0] + e[1]);
        let own = 1.0 - nu;
        Stress::new(nu * trace + own * e[0], nu * trace + own * e[1], 0.5 * own * e[2])
    }
}

impl Sheet for Linear {
    fn energy_density(&self, e: &Strain) -> f64 {
        0.5 * self.stress(e).dot(e)
    }

    fn stress(&self, e: &Strain) -> Stress {
        self.plane() * self.shape(e)
    }

    fn tangent(&self, _: &Strain) -> Mat3 {
        let nu = self.poisson;
        self.plane() * Mat3::new(1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu))
    }

    fn parameters(&self) -> &'static [Parameter] {
        LAW.parameters
    }

    fn add_parameter_vjp(&self, e: &Strain, s_bar: &Strain, out: &mut [f64]) {
        let (nu, trace) = (self.poisson, e[0] + e[1]);
        let along = self.stress(e).dot(s_bar);
        out[0] += along / self.young;
        let by_shape = Stress::new(trace - e[0], trace - e[1], -0.5 * e[2]);
        out[1] += 2.0 * nu / (1.0 - nu * nu) * along + self.plane() * by_shape.dot(s_bar);
    }

    fn natural_width(&self, stretched: f64) -> f64 {
        -self.poisson * stretched
    }
}
