//! Yeoh's law: a cubic in Ī₁.
//!
//! ψ = c₁(Ī₁ − 3) + c₂(Ī₁ − 3)² + c₃(Ī₁ − 3)³ + ½ bulk ln²J
//!
//! Source: Yeoh 1993, "Some forms of the strain energy function for rubber",
//! doi:10.5254/1.3538343; volumetric term as in the Mooney–Rivlin law.
//! Limits: with c₃ < 0, as fits to silicone often have it, the stress turns
//! down at large stretch: mind the range of the fit.

use super::decoupled::{Decoupled, Invariants, Partials};
use super::law::{Law, Moduli, PA, Parameter};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yeoh {
    /// Coefficients of (Ī₁ − 3), its square and its cube [Pa].
    pub c: [f64; 3],
    /// Bulk modulus [Pa].
    pub bulk: f64,
}

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "yeoh",
    formula: "ψ = c1 (Ī1 − 3) + c2 (Ī1 − 3)² + c3 (Ī1 − 3)³ + ½ bulk ln²J",
    parameters: &[
        Parameter::one("c1", PA, "coefficient of Ī1 − 3"),
        Parameter::one("c2", PA, "coefficient of (Ī1 − 3)²"),
        Parameter::one("c3", PA, "coefficient of (Ī1 − 3)³"),
        Parameter::one("bulk", PA, "bulk modulus"),
    ],
    shear: "2 c1",
    bulk: "bulk",
    source: "Yeoh 1993, doi:10.5254/1.3538343",
    limits: "with c3 < 0 the stress turns down at large stretch",
    objective: true,
    moduli: |p| Moduli { shear: 2.0 * p[0], bulk: p[3] },
    build: |p| Box::new(Yeoh { c: [p[0], p[1], p[2]], bulk: p[3] }),
    refuses: |_| None,
    sample: &[24.3e3, 2.25e3, -54.0, 2.4e6],
};

impl Decoupled for Yeoh {
    fn partials(&self, at: &Invariants) -> Partials {
        let ([c1, c2, c3], a) = (self.c, at.a);
        let value = a * (c1 + a * (c2 + a * c3));
        let (first, second) = (c1 + a * (2.0 * c2 + 3.0 * a * c3), 2.0 * c2 + 6.0 * a * c3);
        let volume = Partials::half_log_squared(self.bulk, at);
        volume.with(value, [first, 0.0], [second, 0.0, 0.0])
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        (0..3).for_each(|i| out[i] += at.a.powi(i as i32 + 1) * bar);
        out[3] += 0.5 * at.log_j * at.log_j * bar;
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        out[0] += bar[0];
        out[1] += 2.0 * at.a * bar[0];
        out[2] += 3.0 * at.a * at.a * bar[0];
        out[3] += at.log_j / at.j * bar[2];
    }
}
