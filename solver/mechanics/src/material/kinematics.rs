//! Deformation at one point.

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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariants_agree_with_their_definitions() {
        let h = Mat3::new(0.1, 0.2, -0.1, 0.05, -0.2, 0.3, 0.0, 0.1, 0.15);
        let k = Kinematics::new(&h);
        let b = k.f * k.f.transpose();
        assert!((k.j() - k.f.determinant()).abs() < 1e-14);
        assert!((k.log_j() - k.f.determinant().ln()).abs() < 1e-14);
        assert!((k.left_minus_1() - (b - Mat3::identity())).norm() < 1e-14);
    }
}
