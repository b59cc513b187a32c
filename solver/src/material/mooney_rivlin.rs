//! Three-parameter Mooney–Rivlin law with a logarithmic volumetric term.
//!
//! ψ = c₁(Ī₁ − 3) + c₂(Ī₂ − 3) + c₃(Ī₁ − 3)(Ī₂ − 3) + d₁ ln²J
//! Ī₁ = J^{−2/3} I₁      Ī₂ = J^{−4/3} I₂
//!
//! c₁, c₂, c₃, d₁ [Pa]; small-strain shear modulus 2(c₁ + c₂), bulk modulus
//! 2 d₁.
//!
//! Source: Mooney 1940, Rivlin 1948; this form in the scenes published with
//! Gjoka et al. 2024, "Soft Pneumatic Actuator Design using Differentiable
//! Simulation".

use serde::{Deserialize, Serialize};

use super::{Isotropic, Kinematics, Partials};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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

impl Isotropic for MooneyRivlin {
    fn partials(&self, k: &Kinematics) -> Partials {
        let log_j = k.j_minus_1.ln_1p();
        let j = k.j();
        // r = J^{−2/3} and r − 1, both without cancellation
        let r_minus_1 = (-2.0 / 3.0 * log_j).exp_m1();
        let r = 1.0 + r_minus_1;
        let r2 = r * r;
        let (i1, i2) = (k.i1_minus_3 + 3.0, k.i2_minus_3 + 3.0);
        let a = k.i1_minus_3 * r + 3.0 * r_minus_1;
        let b = k.i2_minus_3 * r2 + 3.0 * r_minus_1 * (r + 1.0);
        let (alpha, gamma) = (self.c1 + self.c3 * b, self.c2 + self.c3 * a);
        let (a_j, b_j) = (-2.0 / 3.0 * i1 * r / j, -4.0 / 3.0 * i2 * r2 / j);
        let (a_jj, b_jj) = (10.0 / 9.0 * i1 * r / (j * j), 28.0 / 9.0 * i2 * r2 / (j * j));
        let volumetric = self.d1 * log_j * log_j;
        Partials {
            value: self.c1 * a + self.c2 * b + self.c3 * a * b + volumetric,
            first: [alpha * r, gamma * r2, alpha * a_j + gamma * b_j + 2.0 * self.d1 * log_j / j],
            second: [
                0.0,
                self.c3 * r * r2,
                0.0,
                self.c3 * b_j * r - 2.0 / 3.0 * alpha * r / j,
                self.c3 * a_j * r2 - 4.0 / 3.0 * gamma * r2 / j,
                2.0 * self.c3 * a_j * b_j
                    + alpha * a_jj
                    + gamma * b_jj
                    + 2.0 * self.d1 * (1.0 - log_j) / (j * j),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Material;
    use super::*;
    use crate::math::tensor::{Mat3, vec9};

    const SILICONE: MooneyRivlin = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 1.7e3, d1: 1e6 };

    fn at(f: &Mat3) -> Kinematics {
        Kinematics::new(&(f - Mat3::identity()))
    }

    fn odd() -> Mat3 {
        Mat3::new(1.2, 0.3, -0.1, 0.05, 0.8, 0.25, -0.2, 0.1, 1.3)
    }

    #[test]
    fn stress_and_tangent_are_the_derivatives() {
        let (f, h) = (odd(), Mat3::new(0.3, -0.2, 0.5, 0.1, 0.4, -0.6, 0.7, 0.2, -0.3));
        let (k, e) = (at(&f), 1e-5);
        let (plus, minus) = (at(&(f + e * h)), at(&(f - e * h)));
        let slope = (SILICONE.energy_density(&plus) - SILICONE.energy_density(&minus)) / (2.0 * e);
        let stress = SILICONE.first_piola(&k);
        assert!((slope / stress.dot(&h) - 1.0).abs() < 1e-8);
        let change = (SILICONE.first_piola(&plus) - SILICONE.first_piola(&minus)) / (2.0 * e);
        let tangent = SILICONE.tangent(&k);
        let predicted = tangent * vec9(&h);
        assert!((vec9(&change) - predicted).norm() / predicted.norm() < 1e-8);
        assert!((tangent - tangent.transpose()).norm() / tangent.norm() < 1e-14);
    }

    #[test]
    fn simple_shear_and_confined_compression_have_their_closed_forms() {
        let gamma = 0.7;
        let mut shear = Mat3::identity();
        shear[(0, 1)] = gamma;
        let exact = 2.0 * gamma * 60e3 + 4.0 * 1.7e3 * gamma * gamma * gamma;
        let stress = SILICONE.first_piola(&at(&shear))[(0, 1)];
        assert!((stress / exact - 1.0).abs() < 1e-13);
        // reference −252377.923 Pa, given to three decimals
        let confined = Mat3::from_diagonal(&nalgebra::Vector3::new(0.9, 1.0, 1.0));
        assert!((SILICONE.first_piola(&at(&confined))[(0, 0)] + 252_377.923).abs() < 1e-3);
    }

    #[test]
    fn rotations_change_neither_energy_nor_stress() {
        let q = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let (k, rotated) = (at(&odd()), at(&(q * odd())));
        let (e, er) = (SILICONE.energy_density(&k), SILICONE.energy_density(&rotated));
        assert!((e / er - 1.0).abs() < 1e-13);
        let difference = SILICONE.first_piola(&rotated) - q * SILICONE.first_piola(&k);
        assert!(difference.norm() / SILICONE.first_piola(&k).norm() < 1e-13);
    }

    #[test]
    fn an_inverted_point_has_infinite_energy() {
        let k = at(&Mat3::from_diagonal(&nalgebra::Vector3::new(-0.5, 1.0, 1.0)));
        assert_eq!(SILICONE.energy_density(&k), f64::INFINITY);
    }
}
