//! Gent's law: chains that can be stretched so far and no further.
//!
//! ψ = −½ μ J_m ln(1 − (Ī₁ − 3)/J_m) + ½ bulk ln²J
//!
//! With x = (Ī₁ − 3)/J_m, ψ = ½ μ (Ī₁ − 3)(1 + x/2 + x²/3 + …): neo-Hookean at small strain
//! and as J_m → ∞, and the first three terms are a law of Yeoh with c₁ = ½ μ, c₂ = ¼ μ/J_m
//! and c₃ = μ/(6 J_m²). A state with Ī₁ − 3 ≥ J_m at any point has infinite energy, and no
//! step of the solver goes there, as for inverted elements.
//!
//! Source: Gent 1996, "A new constitutive relation for rubber", doi:10.5254/1.3538357;
//! volumetric term as in the Mooney–Rivlin law.
//! Limits: near the limit the tangent grows with the inverse square of the distance to it. The
//! limit is one of Ī₁, and ½ bulk ln²J is weak: a bar with bulk = 20 μ and J_m = 5 that is pulled
//! to 6 times its length does so by dilating.

use super::decoupled::{Decoupled, Invariants, Partials};
use super::law::{Law, Moduli, PA, Parameter};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gent {
    /// Shear modulus at rest [Pa].
    pub mu: f64,
    /// Ī₁ − 3 of fully stretched chains [1].
    pub j_m: f64,
    /// Bulk modulus [Pa].
    pub bulk: f64,
}

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "gent",
    formula: "ψ = −½ mu j_m ln(1 − (Ī1 − 3)/j_m) + ½ bulk ln²J",
    parameters: &[
        Parameter::one("mu", PA, "shear modulus at rest"),
        Parameter::one("j_m", "1", "Ī1 − 3 of fully stretched chains, above 0"),
        Parameter::one("bulk", PA, "bulk modulus"),
    ],
    shear: "mu where j_m > 0",
    bulk: "bulk",
    source: "Gent 1996, doi:10.5254/1.3538357",
    limits: "no equilibrium has Ī1 − 3 ≥ j_m: at constant volume uniaxial stretch up to about \
             √(j_m + 3), equibiaxial up to about √((j_m + 3)/2); pulled further, a body dilates",
    objective: true,
    moduli: |p| Moduli { shear: p[0], bulk: p[2] },
    build: |p| Box::new(Gent { mu: p[0], j_m: p[1], bulk: p[2] }),
    refuses: |p| (p[1] <= 0.0).then(|| format!("j_m = {}: must be above 0", p[1])),
    sample: &[31.7e3, 39.6, 2.4e6],
};

impl Gent {
    /// 1 − (Ī₁ − 3)/J_m; not a number where chains would be longer than they are.
    fn room(&self, at: &Invariants) -> f64 {
        let room = 1.0 - at.a / self.j_m;
        if room > 0.0 { room } else { f64::NAN }
    }
}

impl Decoupled for Gent {
    fn partials(&self, at: &Invariants) -> Partials {
        let room = self.room(at);
        let value = -0.5 * self.mu * self.j_m * (-at.a / self.j_m).ln_1p();
        let value = if room.is_nan() { f64::INFINITY } else { value };
        let (first, second) = (0.5 * self.mu / room, 0.5 * self.mu / (self.j_m * room * room));
        let volume = Partials::half_log_squared(self.bulk, at);
        volume.with(value, [first, 0.0], [second, 0.0, 0.0])
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        let (room, log) = (self.room(at), (-at.a / self.j_m).ln_1p());
        out[0] -= 0.5 * self.j_m * log * bar;
        out[1] -= 0.5 * self.mu * (log + at.a / (self.j_m * room)) * bar;
        out[2] += 0.5 * at.log_j * at.log_j * bar;
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        let room = self.room(at);
        out[0] += 0.5 / room * bar[0];
        out[1] -= 0.5 * self.mu * at.a / (self.j_m * room).powi(2) * bar[0];
        out[2] += at.log_j / at.j * bar[2];
    }
}

#[cfg(test)]
mod tests {
    use super::super::response::Mode;
    use super::super::{Kinematics, Material};
    use super::*;
    use crate::math::tensor::Mat3;

    /// Ecoflex 00-30 of Campbell et al. 2025, arXiv:2504.01156.
    const ECOFLEX: Gent = Gent { mu: 31.7e3, j_m: 39.6, bulk: 6.34e6 };

    fn stretched(by: [f64; 3]) -> Kinematics {
        Kinematics::new(&Mat3::from_diagonal(&by.map(|s| s - 1.0).into()))
    }

    #[test]
    fn beyond_the_limit_energy_is_infinite_and_stress_undefined() {
        // the uniaxial stretch with λ² + 2/λ = J_m + 3
        let mut limit = (39.6_f64 + 3.0).sqrt();
        for _ in 0..50 {
            limit = (39.6 + 3.0 - 2.0 / limit).sqrt();
        }
        let at = |l: f64| stretched([l, l.powf(-0.5), l.powf(-0.5)]);
        assert!(ECOFLEX.energy_density(&at(limit - 1e-6)).is_finite());
        let beyond = at(limit + 1e-6);
        assert_eq!(ECOFLEX.energy_density(&beyond), f64::INFINITY);
        assert!(ECOFLEX.first_piola(&beyond)[(0, 0)].is_nan());
        let end = Mode::Uniaxial.stable_up_to(&ECOFLEX, 20.0);
        assert!(end <= limit && end > limit - 2e-3, "{end} {limit}");
    }
}
