//! Nominal stress of an incompressible block under the tests of a laboratory.
//!
//! λ is the stretch along the pull, and the free face carries no load:
//!
//! | mode     | F                   | σ                            |
//! |----------|---------------------|------------------------------|
//! | uniaxial | diag(λ, λ^−½, λ^−½) | force / rest area            |
//! | biaxial  | diag(λ, λ, λ⁻²)     | force / rest area, each side |
//! | planar   | diag(λ, 1, λ⁻¹)     | force / rest area            |
//!
//! At J = 1 the unknown pressure is eliminated by the free face 3:
//! σ = P₁₁ − P₃₃ λ₃/λ₁, for any law, and σ is linear in P, so its derivatives
//! with respect to the parameters come from [`Material::add_parameter_vjp`].
//!
//! A law of constant volume is stable (Drucker) where the second derivatives of ψ by the logarithmic strains h₁ and h₂ of
//! two axes, h₃ = −h₁ − h₂, are positive definite: dτ · dh > 0 for the Kirchhoff stress of any small step. With
//! T_ij = ∂τᵢ/∂h_j = λᵢ λⱼ A_iijj + δ_ij λᵢ Pᵢᵢ they are T_ij − T_i3 − T_3j + T_33.
//!
//! Sources: Ogden, "Non-linear Elastic Deformations", section 7.2; stability: Drucker 1959, doi:10.1115/1.4011929;
//! parameter of the mode: Lode 1926, doi:10.1007/BF01400222.

use nalgebra::{Matrix2, Matrix3, Vector3};
use serde::Serialize;

use super::{Kinematics, Material};
use crate::math::tensor::Mat3;

/// A test of homogeneous strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// Pulled along one axis.
    Uniaxial,
    /// Pulled equally along two axes.
    Biaxial,
    /// Pulled along one axis, held along another ("pure shear").
    Planar,
}

impl Mode {
    /// All modes.
    pub const ALL: [Self; 3] = [Self::Uniaxial, Self::Biaxial, Self::Planar];

    /// The name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Biaxial => "biaxial",
            Self::Planar => "planar",
        }
    }

    /// The name of states that are strained like this. At constant volume compression along one axis is equibiaxial
    /// tension across it.
    pub fn state(self) -> &'static str {
        match self {
            Self::Uniaxial => "tension",
            Self::Biaxial => "biaxial",
            Self::Planar => "planar",
        }
    }

    /// The mode that a state with these principal stretches, the largest first, is nearest to, by Lode's parameter
    /// (2 h₂ − h₁ − h₃)/(h₁ − h₃) of the logarithmic strains h: −1 in uniaxial, 0 in planar, 1 in biaxial tension.
    pub fn nearest(stretches: [f64; 3]) -> Self {
        let [first, second, third] = stretches.map(f64::ln);
        match (2.0 * second - first - third) / (first - third) {
            ..-0.5 => Self::Uniaxial,
            0.5.. => Self::Biaxial,
            _ => Self::Planar,
        }
    }

    /// Principal stretches at stretch λ along the pull.
    pub fn stretches(self, lambda: f64) -> [f64; 3] {
        match self {
            Self::Uniaxial => [lambda, lambda.powf(-0.5), lambda.powf(-0.5)],
            Self::Biaxial => [lambda, lambda, lambda.powi(-2)],
            Self::Planar => [lambda, 1.0, 1.0 / lambda],
        }
    }

    /// Deformation and the weights of σ = Σ weightᵢ Pᵢᵢ.
    fn block(self, lambda: f64) -> (Kinematics, Mat3) {
        let stretch = self.stretches(lambda);
        let grad_u = Mat3::from_diagonal(&Vector3::from(stretch.map(|s| s - 1.0)));
        let weights = Vector3::new(1.0, 0.0, -stretch[2] / stretch[0]);
        (Kinematics::new(&grad_u), Mat3::from_diagonal(&weights))
    }

    /// Nominal stress σ(λ) [Pa].
    pub fn nominal_stress(self, material: &dyn Material, lambda: f64) -> f64 {
        let (k, weights) = self.block(lambda);
        material.first_piola(&k).dot(&weights)
    }

    /// Adds ∂σ/∂parameters.
    pub fn add_stress_gradient(self, material: &dyn Material, lambda: f64, out: &mut [f64]) {
        let (k, weights) = self.block(lambda);
        material.add_parameter_vjp(&k, &weights, out);
    }

    /// Whether small steps of any kind from the state at stretch λ take work (Drucker).
    fn is_stable(self, material: &dyn Material, lambda: f64) -> bool {
        let (k, _) = self.block(lambda);
        let (stress, tangent) = (material.first_piola(&k), material.tangent(&k));
        let l = self.stretches(lambda);
        // vec has (i, i) at 4 i
        let t = Matrix3::from_fn(|i, j| {
            let own = if i == j { l[i] * stress[(i, i)] } else { 0.0 };
            l[i] * l[j] * tangent[(4 * i, 4 * j)] + own
        });
        let h = Matrix2::from_fn(|i, j| t[(i, j)] - t[(i, 2)] - t[(2, j)] + t[(2, 2)]);
        h.trace() > 0.0 && h.determinant() > 0.0
    }

    /// The stretch up to which σ rises with λ and the law is stable, looked for up to `limit`;
    /// infinite when that is so all the way. Compression along one axis is biaxial tension across it, and so on: with
    /// λ > 1 in all modes there is nothing else.
    pub fn stable_up_to(self, material: &dyn Material, limit: f64) -> f64 {
        let step = 1e-3;
        let mut stress = 0.0;
        let mut lambda = 1.0;
        while lambda < limit {
            let next = self.nominal_stress(material, lambda + step);
            if next.is_nan() || next <= stress || !self.is_stable(material, lambda + step) {
                return lambda;
            }
            (lambda, stress) = (lambda + step, next);
        }
        f64::INFINITY
    }
}

/// Nominal stress [Pa] and lateral stretch of a block of compressible material
/// whose sides are free, at stretch λ along the pull.
///
/// Newton's method for P₂₂ = 0, halved while it would leave J > 0 or what the law admits, or
/// not lower |P₂₂|.
pub fn free_uniaxial(material: &dyn Material, lambda: f64) -> (f64, f64) {
    let block = |side: f64| {
        Kinematics::new(&Mat3::from_diagonal(&Vector3::new(lambda - 1.0, side - 1.0, side - 1.0)))
    };
    let residual = |side: f64| material.first_piola(&block(side))[(1, 1)];
    let size = |side: f64| Some(residual(side).abs()).filter(|r| !r.is_nan());
    let mut side = lambda.powf(-0.5);
    for _ in 0..50 {
        let tangent = material.tangent(&block(side));
        // vec index 4 is component (2, 2), index 8 is (3, 3)
        let mut step = -residual(side) / (tangent[(4, 4)] + tangent[(4, 8)]);
        while side + step <= 0.0 || size(side + step).is_none_or(|r| r > residual(side).abs()) {
            step *= 0.5;
            if step.abs() < f64::EPSILON * side {
                return (material.first_piola(&block(side))[(0, 0)], side);
            }
        }
        side += step;
    }
    (material.first_piola(&block(side))[(0, 0)], side)
}

#[cfg(test)]
mod tests {
    use super::super::{ArrudaBoyce, Gent, Lame, MooneyRivlin, NeoHookean, Ogden, Yeoh};
    use super::*;

    /// Laws in Ī₁ have σ = 2 ψ′(Ī₁) (λ − λ⁻²), (λ − λ⁻⁵) and (λ − λ⁻³): Ogden, section 7.2. Where Gent's chains would be
    /// longer than they are, there is none.
    #[test]
    fn laws_in_the_first_invariant_have_their_closed_forms() {
        let (neo, bulk) = (NeoHookean(Lame::new(1e5, 0.35)), 1e6);
        let yeoh = Yeoh { c: [13.5e3, 579.0, -7.6], bulk };
        let gent = Gent { mu: 31.7e3, j_m: 39.6, bulk };
        let long = ArrudaBoyce { mu: 60e3, lambda_m: 1e6, bulk };
        type Slope<'a> = &'a dyn Fn(f64) -> f64;
        let laws: [(&dyn Material, Slope); 4] = [
            (&neo, &|_| 0.5 * neo.0.mu),
            (&yeoh, &|a| 13.5e3 + 2.0 * 579.0 * a - 3.0 * 7.6 * a * a),
            (&gent, &|a| if a < 39.6 { 0.5 * 31.7e3 * 39.6 / (39.6 - a) } else { f64::NAN }),
            (&long, &|_| 0.5 * 60e3),
        ];
        for l in [0.5_f64, 0.9, 1.3, 2.5, 5.0] {
            for mode in Mode::ALL {
                let [a, b, c] = mode.stretches(l);
                let excess = a * a + b * b + c * c - 3.0;
                for (law, slope) in &laws {
                    let exact = 2.0 * slope(excess) * (l - c * c / l);
                    let stress = mode.nominal_stress(*law, l);
                    let close = (stress / exact - 1.0).abs() < 1e-10;
                    assert!(close || (exact.is_nan() && stress.is_nan()), "{mode:?} {l}: {stress}");
                }
            }
        }
    }

    #[test]
    fn ogden_has_its_closed_form() {
        let (mu, alpha) = (17e3, 2.76);
        let ogden = Ogden { terms: vec![(mu, alpha)], bulk: 1e6 };
        for l in [0.7_f64, 1.4, 3.0] {
            let exact = mu * (l.powf(alpha - 1.0) - l.powf(-0.5 * alpha - 1.0));
            let stress = Mode::Uniaxial.nominal_stress(&ogden, l);
            assert!((stress / exact - 1.0).abs() < 1e-12);
        }
    }

    /// With c₂ = −c₁/10 uniaxial stress rises all the way, but two sides of the strip give way at λ² = 10, where
    /// c₁ (λ₂² + λ₃²) + c₂ (λ₂⁻² + λ₃⁻²) = 2 (c₁/λ + c₂ λ) is zero.
    #[test]
    fn what_gives_way_across_the_pull_is_found() {
        let law = MooneyRivlin { c1: 1e5, c2: -1e4, c3: 0.0, d1: 1e7 };
        let stress = |l: f64| Mode::Uniaxial.nominal_stress(&law, l);
        assert!((30..60).all(|i| stress(0.1 * f64::from(i + 1)) > stress(0.1 * f64::from(i))));
        let end = Mode::Uniaxial.stable_up_to(&law, 20.0);
        assert!((end - 10.0_f64.sqrt()).abs() < 2e-3, "{end}");
    }

    #[test]
    fn states_are_nearest_to_their_own_mode() {
        for mode in Mode::ALL {
            for l in [1.01, 2.0, 6.0] {
                let mut stretches = mode.stretches(l);
                stretches.sort_by(|a, b| b.total_cmp(a));
                assert_eq!(Mode::nearest(stretches), mode);
                // of another volume
                assert_eq!(Mode::nearest(stretches.map(|s| 1.1 * s)), mode);
            }
        }
        // compression along one axis
        assert_eq!(Mode::nearest([1.4, 1.4, 0.5]), Mode::Biaxial);
    }

    #[test]
    fn a_falling_yeoh_stress_is_found() {
        // Dragon Skin 10, a fit to 300 % [Pa]: monotone up to 4.5 in a
        // uniaxial test, says an independent fit
        let yeoh = Yeoh { c: [24.293e3, 2250.0, -54.28], bulk: 1e6 };
        let end = Mode::Uniaxial.stable_up_to(&yeoh, 20.0);
        assert!((end - 4.5).abs() < 0.05, "{end}");
        assert!(Mode::Biaxial.stable_up_to(&yeoh, 20.0) < end);
        let rising = Yeoh { c: [24e3, 2e3, 1.0], bulk: 1e6 };
        assert_eq!(Mode::Biaxial.stable_up_to(&rising, 20.0), f64::INFINITY);
    }
}
