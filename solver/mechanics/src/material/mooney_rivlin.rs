//! Three-parameter Mooney–Rivlin law with a logarithmic volumetric term.
//!
//! ψ = c₁(Ī₁ − 3) + c₂(Ī₂ − 3) + c₃(Ī₁ − 3)(Ī₂ − 3) + d₁ ln²J
//!
//! Source: Mooney 1940, Rivlin 1948; this form in the scenes published with
//! Gjoka et al. 2024, "Soft Pneumatic Actuator Design using Differentiable
//! Simulation", where it is called `MooneyRivlin3ParamSymbolic`.
//! Limits: ln²J is a weak barrier against J → 0.

use super::decoupled::{Decoupled, Invariants, Partials};
use super::law::{Law, Moduli, PA, Parameter};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlin {
    /// Coefficient of Ī₁ − 3 [Pa].
    pub c1: f64,
    /// Coefficient of Ī₂ − 3 [Pa].
    pub c2: f64,
    /// Coefficient of (Ī₁ − 3)(Ī₂ − 3) [Pa].
    pub c3: f64,
    /// Coefficient of ln²J [Pa].
    pub d1: f64,
}

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "mooney-rivlin",
    formula: "ψ = c1 (Ī1 − 3) + c2 (Ī2 − 3) + c3 (Ī1 − 3)(Ī2 − 3) + d1 ln²J",
    parameters: &[
        Parameter::one("c1", PA, "coefficient of Ī1 − 3"),
        Parameter::one("c2", PA, "coefficient of Ī2 − 3"),
        Parameter::one("c3", PA, "coefficient of (Ī1 − 3)(Ī2 − 3)"),
        Parameter::one("d1", PA, "coefficient of the volumetric term"),
    ],
    shear: "2 (c1 + c2)",
    bulk: "2 d1",
    source: "Mooney 1940, doi:10.1063/1.1712836; Rivlin 1948, doi:10.1098/rsta.1948.0024; \
             this form: scenes of Gjoka et al. 2024 (MooneyRivlin3ParamSymbolic)",
    limits: "",
    objective: true,
    moduli: |p| Moduli { shear: 2.0 * (p[0] + p[1]), bulk: 2.0 * p[3] },
    build: |p| Box::new(MooneyRivlin { c1: p[0], c2: p[1], c3: p[2], d1: p[3] }),
    refuses: |_| None,
    sample: &[55e3, 5e3, 1.7e3, 1e6],
};

/// Value and derivatives of c₁a + c₂b + c₃ab, without the volumetric term.
pub(super) fn isochoric(c: [f64; 3], at: &Invariants) -> Partials {
    let (a, b) = (at.a, at.b);
    Partials {
        value: c[0] * a + c[1] * b + c[2] * a * b,
        first: [c[0] + c[2] * b, c[1] + c[2] * a, 0.0],
        second: [0.0, c[2], 0.0, 0.0],
    }
}

impl Decoupled for MooneyRivlin {
    fn partials(&self, at: &Invariants) -> Partials {
        let mut p = isochoric([self.c1, self.c2, self.c3], at);
        p.value += self.d1 * at.log_j * at.log_j;
        p.first[2] = 2.0 * self.d1 * at.log_j / at.j;
        p.second[3] = 2.0 * self.d1 * (1.0 - at.log_j) / (at.j * at.j);
        p
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        out[0] += at.a * bar;
        out[1] += at.b * bar;
        out[2] += at.a * at.b * bar;
        out[3] += at.log_j * at.log_j * bar;
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        out[0] += bar[0];
        out[1] += bar[1];
        out[2] += at.b * bar[0] + at.a * bar[1];
        out[3] += 2.0 * at.log_j / at.j * bar[2];
    }
}
