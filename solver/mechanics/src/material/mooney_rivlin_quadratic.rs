//! Three-parameter Mooney–Rivlin law with a quadratic volumetric term.
//!
//! ψ = c₁(Ī₁ − 3) + c₂(Ī₂ − 3) + c₃(Ī₁ − 3)(Ī₂ − 3) + d₁ (J − 1)²
//!
//! Same small-strain moduli as the logarithmic variant, another energy: at
//! J = 0.95 its pressure is 8 % lower.
//!
//! Source: Mooney 1940, Rivlin 1948; called `MooneyRivlin3Param` in PolyFEM.
//! Limits: finite at J = 0, so the step to J ≤ 0 is a jump to infinity.

use super::decoupled::{Decoupled, Invariants, Partials};
use super::law::{Law, Moduli, PA, Parameter};
use super::mooney_rivlin::isochoric;

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlinQuadratic {
    /// Coefficient of Ī₁ − 3 [Pa].
    pub c1: f64,
    /// Coefficient of Ī₂ − 3 [Pa].
    pub c2: f64,
    /// Coefficient of (Ī₁ − 3)(Ī₂ − 3) [Pa].
    pub c3: f64,
    /// Coefficient of (J − 1)² [Pa].
    pub d1: f64,
}

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "mooney-rivlin-quadratic",
    formula: "ψ = c1 (Ī1 − 3) + c2 (Ī2 − 3) + c3 (Ī1 − 3)(Ī2 − 3) + d1 (J − 1)²",
    parameters: &[
        Parameter::one("c1", PA, "coefficient of Ī1 − 3"),
        Parameter::one("c2", PA, "coefficient of Ī2 − 3"),
        Parameter::one("c3", PA, "coefficient of (Ī1 − 3)(Ī2 − 3)"),
        Parameter::one("d1", PA, "coefficient of the volumetric term"),
    ],
    shear: "2 (c1 + c2)",
    bulk: "2 d1",
    source: "Mooney 1940, doi:10.1063/1.1712836; Rivlin 1948, doi:10.1098/rsta.1948.0024; \
             this form: PolyFEM (MooneyRivlin3Param)",
    limits: "another energy than mooney-rivlin; do not mix their parameters at large changes \
             of volume",
    objective: true,
    moduli: |p| Moduli { shear: 2.0 * (p[0] + p[1]), bulk: 2.0 * p[3] },
    build: |p| Box::new(MooneyRivlinQuadratic { c1: p[0], c2: p[1], c3: p[2], d1: p[3] }),
    refuses: |_| None,
    sample: &[50e3, 8e3, 1e3, 1.3e6],
};

impl Decoupled for MooneyRivlinQuadratic {
    fn partials(&self, at: &Invariants) -> Partials {
        let mut p = isochoric([self.c1, self.c2, self.c3], at);
        p.value += self.d1 * at.j_minus_1 * at.j_minus_1;
        p.first[2] = 2.0 * self.d1 * at.j_minus_1;
        p.second[3] = 2.0 * self.d1;
        p
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        out[0] += at.a * bar;
        out[1] += at.b * bar;
        out[2] += at.a * at.b * bar;
        out[3] += at.j_minus_1 * at.j_minus_1 * bar;
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        out[0] += bar[0];
        out[1] += bar[1];
        out[2] += at.b * bar[0] + at.a * bar[1];
        out[3] += 2.0 * at.j_minus_1 * bar[2];
    }
}
