//! Three-parameter Mooney–Rivlin laws, with a logarithmic or a quadratic volumetric term.
//!
//! ψ = c₁(Ī₁ − 3) + c₂(Ī₂ − 3) + c₃(Ī₁ − 3)(Ī₂ − 3) + d₁ ln²J
//! ψ = c₁(Ī₁ − 3) + c₂(Ī₂ − 3) + c₃(Ī₁ − 3)(Ī₂ − 3) + d₁ (J − 1)²
//!
//! Both have the same small-strain moduli, and other energies: at J = 0.95 the pressure of the quadratic one is 8 %
//! lower.
//!
//! Source: Mooney 1940, Rivlin 1948; the first form in the scenes published with
//! Gjoka et al. 2024, "Soft Pneumatic Actuator Design using Differentiable
//! Simulation", where it is called `MooneyRivlin3ParamSymbolic`; the second is called `MooneyRivlin3Param` in PolyFEM.
//! Limits: ln²J is a weak barrier against J → 0; the quadratic term is finite there, so that the step to J ≤ 0 is a
//! jump to infinity.

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

/// The same parameters with (J − 1)² in place of ln²J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlinQuadratic(pub MooneyRivlin);

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
    build: |p| Box::new(MooneyRivlin::new(p)),
    refuses: |_| None,
    sample: &[55e3, 5e3, 1.7e3, 1e6],
};

/// The row of the quadratic one.
pub(super) const QUADRATIC: Law = Law {
    key: "mooney-rivlin-quadratic",
    formula: "ψ = c1 (Ī1 − 3) + c2 (Ī2 − 3) + c3 (Ī1 − 3)(Ī2 − 3) + d1 (J − 1)²",
    source: "Mooney 1940, doi:10.1063/1.1712836; Rivlin 1948, doi:10.1098/rsta.1948.0024; \
             this form: PolyFEM (MooneyRivlin3Param)",
    limits: "another energy than mooney-rivlin; do not mix their parameters at large changes \
             of volume",
    build: |p| Box::new(MooneyRivlinQuadratic(MooneyRivlin::new(p))),
    sample: &[50e3, 8e3, 1e3, 1.3e6],
    ..LAW
};

impl MooneyRivlin {
    fn new(p: &[f64]) -> Self {
        Self { c1: p[0], c2: p[1], c3: p[2], d1: p[3] }
    }

    /// With the partial derivatives of a volumetric term.
    fn with(&self, at: &Invariants, volume: Partials) -> Partials {
        let (Self { c1, c2, c3, .. }, a, b) = (*self, at.a, at.b);
        let value = c1 * a + c2 * b + c3 * a * b;
        volume.with(value, [c1 + c3 * b, c2 + c3 * a], [0.0, c3, 0.0])
    }
}

impl Decoupled for MooneyRivlin {
    fn partials(&self, at: &Invariants) -> Partials {
        self.with(at, Partials::half_log_squared(2.0 * self.d1, at))
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

impl Decoupled for MooneyRivlinQuadratic {
    fn partials(&self, at: &Invariants) -> Partials {
        let (d1, x) = (self.0.d1, at.j_minus_1);
        let (first, second) = ([0.0, 0.0, 2.0 * d1 * x], [0.0, 0.0, 0.0, 2.0 * d1]);
        self.0.with(at, Partials { value: d1 * x * x, first, second })
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        self.0.add_value_vjp(&Invariants { log_j: at.j_minus_1, ..*at }, bar, out);
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        let flat = Invariants { log_j: at.j_minus_1, j: 1.0, ..*at };
        self.0.add_partials_vjp(&flat, bar, out);
    }
}
