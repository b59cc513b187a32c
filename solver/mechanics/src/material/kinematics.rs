//! Deformation at one point.

use crate::math::remainder::ln_1p_minus;
use crate::math::tensor::{Mat3, cofactor};

/// F = I + ∇u and what follows from it.
///
/// Differences to the rest state are formed from ∇u, so that they keep their
/// digits at small strain.
pub struct Kinematics {
    /// Displacement gradient ∇u.
    pub grad_u: Mat3,
    /// Deformation gradient F.
    pub f: Mat3,
    /// cof F = J F⁻ᵀ.
    pub cofactor: Mat3,
    /// Green–Lagrange strain E = ½(FᵀF − I).
    pub green: Mat3,
    /// J − 1 = det F − 1.
    pub j_minus_1: f64,
}

impl Kinematics {
    /// From the displacement gradient ∇u.
    pub fn new(grad_u: &Mat3) -> Self {
        let h = grad_u;
        let f = Mat3::identity() + h;
        let minors = cofactor(h).trace();
        Self {
            grad_u: *h,
            f,
            cofactor: cofactor(&f),
            green: 0.5 * (h + h.transpose() + h.transpose() * h),
            j_minus_1: h.trace() + minors + h.determinant(),
        }
    }

    /// J = det F.
    pub fn j(&self) -> f64 {
        1.0 + self.j_minus_1
    }

    /// ln J.
    pub fn log_j(&self) -> f64 {
        self.j_minus_1.ln_1p()
    }

    /// FFᵀ − I.
    pub fn left_minus_1(&self) -> Mat3 {
        let h = &self.grad_u;
        h + h.transpose() + h * h.transpose()
    }

    /// [I₁ − 3 − 2 ln J, I₂ − 3 − 4 ln J]: what of the invariants is of second
    /// order in strain.
    ///
    /// J² = det(I + 2E) = 1 + 2 I_E + 4 II_E + 8 III_E: the terms of first order
    /// cancel on paper, not in the computer.
    pub fn excess(&self) -> [f64; 2] {
        let (second, third) = (self.second(), self.green.determinant());
        let log = ln_1p_minus(self.j_minus_1 * (2.0 + self.j_minus_1));
        [-log - 4.0 * second - 8.0 * third, -2.0 * log - 4.0 * second - 16.0 * third]
    }

    /// II_E = ½(tr²E − tr E²).
    fn second(&self) -> f64 {
        cofactor(&self.green).trace()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariants_agree_with_their_definitions() {
        let h = Mat3::new(0.1, 0.2, -0.1, 0.05, -0.2, 0.3, 0.0, 0.1, 0.15);
        let k = Kinematics::new(&h);
        let (c, b) = (k.f.transpose() * k.f, k.f * k.f.transpose());
        let i1 = c.trace();
        let i2 = 0.5 * (i1 * i1 - (c * c).trace());
        let log_j = k.f.determinant().ln();
        assert!((k.j() - k.f.determinant()).abs() < 1e-14);
        assert!((k.log_j() - log_j).abs() < 1e-14);
        assert!((k.left_minus_1() - (b - Mat3::identity())).norm() < 1e-14);
        let [first, second] = k.excess();
        assert!((first - (i1 - 3.0 - 2.0 * log_j)).abs() < 1e-14);
        assert!((second - (i2 - 3.0 - 4.0 * log_j)).abs() < 1e-14);
    }

    #[test]
    fn excess_keeps_its_digits_at_tiny_strain() {
        // F = diag(1 + e, 1, 1): I₁ − 3 − 2 ln J = 2e² − 2e³/3 …, and I₂ twice that
        let e = 1e-9;
        let k = Kinematics::new(&Mat3::from_diagonal(&nalgebra::Vector3::new(e, 0.0, 0.0)));
        let [first, second] = k.excess();
        assert!((first / (2.0 * e * e) - 1.0).abs() < 2e-9);
        assert!((second / (4.0 * e * e) - 1.0).abs() < 2e-9);
    }
}
