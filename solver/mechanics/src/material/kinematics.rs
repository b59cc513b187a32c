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
