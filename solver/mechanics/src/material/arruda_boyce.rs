//! The law of Arruda and Boyce: eight chains of limited length in a cube.
//!
//! ψ = μ Σᵢ cᵢ λ_m^(2−2i) (Ī₁ⁱ − 3ⁱ) + ½ bulk ln²J      i = 1 … 5
//! c = 1/2, 1/20, 11/1050, 19/7000, 519/673750
//!
//! The sum is the series of the inverse Langevin function. As λ_m → ∞ the law is neo-Hookean. The shear
//! modulus at rest is above μ: 2 ψ'(3) = 2 μ Σᵢ i cᵢ (3/λ_m²)^(i−1).
//!
//! Source: Arruda and Boyce 1993, "A three-dimensional constitutive model for the large stretch
//! behavior of rubber elastic materials", doi:10.1016/0022-5096(93)90013-6; volumetric term as in
//! the Mooney–Rivlin law.
//! Limits: with five terms the stress stays finite beyond the stretch at which chains lock.

use super::decoupled::{Decoupled, Invariants, Partials};
use super::law::{Law, Moduli, PA, Parameter};

/// cᵢ.
const SERIES: [f64; 5] = [1.0 / 2.0, 1.0 / 20.0, 11.0 / 1050.0, 19.0 / 7000.0, 519.0 / 673_750.0];

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrudaBoyce {
    /// Modulus of the chains [Pa].
    pub mu: f64,
    /// Stretch at which chains lock [1].
    pub lambda_m: f64,
    /// Bulk modulus [Pa].
    pub bulk: f64,
}

/// The row of the table.
pub(super) const LAW: Law = Law {
    key: "arruda-boyce",
    formula: "ψ = mu Σ c_i lambda_m^(2−2i) (Ī1^i − 3^i) + ½ bulk ln²J, i = 1 … 5",
    parameters: &[
        Parameter::one("mu", PA, "modulus of the chains"),
        Parameter::one("lambda_m", "1", "stretch at which chains lock, above 1"),
        Parameter::one("bulk", PA, "bulk modulus"),
    ],
    shear: "2 mu Σ i c_i (3/lambda_m²)^(i−1) where lambda_m > 1",
    bulk: "bulk",
    source: "Arruda and Boyce 1993, doi:10.1016/0022-5096(93)90013-6",
    limits: "five terms of a series: beyond the stretch at which chains lock it is too soft",
    objective: true,
    moduli: |p| {
        let law = ArrudaBoyce { mu: p[0], lambda_m: p[1], bulk: p[2] };
        Moduli { shear: 2.0 * p[0] * law.slope(3.0), bulk: p[2] }
    },
    build: |p| Box::new(ArrudaBoyce { mu: p[0], lambda_m: p[1], bulk: p[2] }),
    refuses: |p| (p[1] <= 1.0).then(|| format!("lambda_m = {}: must be above 1", p[1])),
    sample: &[60e3, 2.8, 2.4e6],
};

impl ArrudaBoyce {
    /// Σᵢ f(i) cᵢ λ_m^(2−2i).
    fn sum(&self, of: impl Fn(i32) -> f64) -> f64 {
        let chain = |(i, c): (i32, &f64)| of(i) * c * self.lambda_m.powi(2 - 2 * i);
        (1..).zip(&SERIES).map(chain).sum()
    }

    /// ∂ψ/∂Ī₁ / μ.
    fn slope(&self, i1: f64) -> f64 {
        self.sum(|i| f64::from(i) * i1.powi(i - 1))
    }
}

/// Ī₁ⁱ − 3ⁱ, as a product with Ī₁ − 3, which has all digits at small strain.
fn rise(at: &Invariants, i: i32) -> f64 {
    let i1 = at.a + 3.0;
    at.a * (0..i).map(|k| i1.powi(k) * 3.0_f64.powi(i - 1 - k)).sum::<f64>()
}

impl Decoupled for ArrudaBoyce {
    fn partials(&self, at: &Invariants) -> Partials {
        let i1 = at.a + 3.0;
        let twice = |i: i32| f64::from(i * (i - 1)) * i1.powi(i - 2);
        let value = self.mu * self.sum(|i| rise(at, i));
        let (first, second) = (self.mu * self.slope(i1), self.mu * self.sum(twice));
        let volume = Partials::half_log_squared(self.bulk, at);
        volume.with(value, [first, 0.0], [second, 0.0, 0.0])
    }

    fn parameter_count(&self) -> usize {
        LAW.parameters.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        let by_lambda = self.sum(|i| f64::from(2 - 2 * i) * rise(at, i)) / self.lambda_m;
        out[0] += self.sum(|i| rise(at, i)) * bar;
        out[1] += self.mu * by_lambda * bar;
        out[2] += 0.5 * at.log_j * at.log_j * bar;
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        let i1 = at.a + 3.0;
        let by_lambda = self.sum(|i| f64::from(i * (2 - 2 * i)) * i1.powi(i - 1)) / self.lambda_m;
        out[0] += self.slope(i1) * bar[0];
        out[1] += self.mu * by_lambda * bar[0];
        out[2] += at.log_j / at.j * bar[2];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse Langevin function: its series is 3 x + 9/5 x³ + 297/175 x⁵ + …, x = λ_chain/λ_m.
    #[test]
    fn the_series_is_that_of_the_inverse_langevin_function() {
        // cᵢ of ψ by integrating the series over λ_chain² = Ī₁/3
        let langevin = [3.0, 9.0 / 5.0, 297.0 / 175.0, 1539.0 / 875.0, 126_117.0 / 67_375.0];
        for (i, (c, l)) in (1..).zip(SERIES.iter().zip(langevin)) {
            let integrated = l / (2.0 * f64::from(i) * 3.0_f64.powi(i));
            assert!((c / integrated - 1.0).abs() < 1e-12, "{i}: {c} {integrated}");
        }
    }
}
