//! Laws in two parts: ψ(F) = ψ_p(F) + U(J), of which U is of the change of volume alone.
//!
//! U is the term of a law in J by itself, such as ½ bulk ln²J, so that ψ_p has no bulk modulus that
//! could be large: elements whose volume changes as a whole (mean dilatation) take U of the mean of J
//! and ψ_p at every point. At rest both parts are free of energy and stress.
//!
//! Source: Simo, Taylor and Pister 1985, "Variational and projection methods for the volume
//! constraint in finite deformation elasto-plasticity", doi:10.1016/0045-7825(85)90033-7.

use std::sync::Arc;

use super::{Invariants, Isotropic, Kinematics, Material, Partials};
use crate::math::tensor::{Mat3, Mat9, add_j_hessian, vec9};

/// A law in two parts.
#[derive(Clone)]
pub struct Split {
    /// ψ_p. It has all parameters of the law; those of U do nothing.
    pub pointwise: Arc<dyn Material>,
    /// A law that is U(J) at Ī₁ = Ī₂ = 3, with all parameters.
    volumetric: Arc<dyn Isotropic>,
}

impl Split {
    /// From ψ_p, and a law that is U(J) at Ī₁ = Ī₂ = 3.
    pub(super) fn new(
        pointwise: impl Material + 'static,
        volumetric: impl Isotropic + 'static,
    ) -> Self {
        Self { pointwise: Arc::new(pointwise), volumetric: Arc::new(volumetric) }
    }

    /// The two parts of a law, from the law and its U.
    pub(super) fn by_difference(
        law: impl Material + 'static,
        volumetric: impl Isotropic + Clone + 'static,
    ) -> Self {
        Self::new(Difference { law, volumetric: volumetric.clone() }, volumetric)
    }

    /// U [J/m³], U' and U'' [Pa] at J − 1; infinite where J is not positive.
    #[must_use]
    pub fn volumetric(&self, j_minus_1: f64) -> [f64; 3] {
        derivatives(&*self.volumetric, j_minus_1)
    }

    /// Adds bar ∂U'/∂parameters at J − 1.
    pub fn add_volumetric_vjp(&self, j_minus_1: f64, bar: f64, out: &mut [f64]) {
        self.volumetric.add_partials_vjp(&ball(j_minus_1), [0.0, 0.0, bar], out);
    }
}

/// A body that is as large as J says, and of the same shape as at rest.
fn ball(j_minus_1: f64) -> Invariants {
    let (j, log_j) = (1.0 + j_minus_1, j_minus_1.ln_1p());
    Invariants { a: 0.0, b: 0.0, j, log_j, j_minus_1 }
}

fn derivatives(volumetric: &dyn Isotropic, j_minus_1: f64) -> [f64; 3] {
    if j_minus_1 <= -1.0 {
        return [f64::INFINITY; 3];
    }
    let Partials { value, first, second } = volumetric.partials(&ball(j_minus_1));
    [value, first[2], second[3]]
}

/// The partial derivatives of ½ k ln²J.
pub(super) fn half_log_squared(k: f64, at: &Invariants) -> Partials {
    let (log_j, j) = (at.log_j, at.j);
    Partials {
        value: 0.5 * k * log_j * log_j,
        first: [0.0, 0.0, k * log_j / j],
        second: [0.0, 0.0, 0.0, k * (1.0 - log_j) / (j * j)],
    }
}

/// ψ − U.
struct Difference<M, V> {
    law: M,
    volumetric: V,
}

impl<M: Material, V: Isotropic> Material for Difference<M, V> {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        if k.j() <= 0.0 {
            return f64::INFINITY;
        }
        self.law.energy_density(k) - derivatives(&self.volumetric, k.j_minus_1)[0]
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        self.law.first_piola(k) - derivatives(&self.volumetric, k.j_minus_1)[1] * k.cofactor
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let [_, first, second] = derivatives(&self.volumetric, k.j_minus_1);
        let by_j = vec9(&k.cofactor);
        let mut tangent = self.law.tangent(k) - second * by_j * by_j.transpose();
        add_j_hessian(&k.f, -first, &mut tangent);
        tangent
    }

    fn parameter_count(&self) -> usize {
        self.law.parameter_count()
    }

    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]) {
        self.law.add_parameter_vjp(k, p_bar, out);
        let bar = [0.0, 0.0, -k.cofactor.dot(p_bar)];
        self.volumetric.add_partials_vjp(&ball(k.j_minus_1), bar, out);
    }
}
