//! Deformation at one point.

use crate::math::tensor::{Mat3, cofactor};

/// F = I + ∇u and its invariants.
///
/// Differences to the rest state are formed from ∇u, so that they keep their
/// digits at small strain.
pub struct Kinematics {
    /// Deformation gradient.
    pub f: Mat3,
    /// cof F = J F⁻ᵀ.
    pub cofactor: Mat3,
    /// C = FᵀF.
    pub c: Mat3,
    /// J − 1 = det F − 1.
    pub j_minus_1: f64,
    /// I₁ − 3 = tr C − 3.
    pub i1_minus_3: f64,
    /// I₂ − 3 = ½(I₁² − tr C²) − 3.
    pub i2_minus_3: f64,
}

impl Kinematics {
    /// From the displacement gradient ∇u.
    #[must_use]
    pub fn new(grad_u: &Mat3) -> Self {
        let h = grad_u;
        let f = Mat3::identity() + h;
        // E = ½(C − I): tr E and ½(tr²E − tr E²) give I₁ and I₂
        let green = 0.5 * (h + h.transpose() + h.transpose() * h);
        let trace = green.trace();
        let second = 0.5 * (trace * trace - green.norm_squared());
        let minors = cofactor(h).trace();
        Self {
            f,
            cofactor: cofactor(&f),
            c: f.transpose() * f,
            j_minus_1: h.trace() + minors + h.determinant(),
            i1_minus_3: 2.0 * trace,
            i2_minus_3: 4.0 * trace + 4.0 * second,
        }
    }

    /// J = det F.
    #[must_use]
    pub fn j(&self) -> f64 {
        1.0 + self.j_minus_1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariants_agree_with_their_definitions() {
        let h = Mat3::new(0.1, 0.2, -0.1, 0.05, -0.2, 0.3, 0.0, 0.1, 0.15);
        let k = Kinematics::new(&h);
        let i1 = k.c.trace();
        let i2 = 0.5 * (i1 * i1 - (k.c * k.c).trace());
        assert!((k.i1_minus_3 - (i1 - 3.0)).abs() < 1e-14);
        assert!((k.i2_minus_3 - (i2 - 3.0)).abs() < 1e-14);
        assert!((k.j() - k.f.determinant()).abs() < 1e-14);
    }
}
