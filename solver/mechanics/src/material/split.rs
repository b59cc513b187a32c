//! Laws in two parts: ψ(F) = ψ_p(F) + U_m(J), of which U_m is of the change of volume alone.
//!
//! With U the term of a law in J by itself, such as ½ bulk ln²J,
//!
//! U_m = (1 − θ) U      θ = 2 G/U''(1), at most 1      G: shear modulus at rest
//!
//! so that ψ_p has no bulk modulus that could be large: elements whose volume changes as a whole (mean dilatation) take
//! U_m of the mean of J and ψ_p at every point. At rest both parts are free of energy and stress.
//!
//! With θ = 0 the volume of a point costs nothing beside that of its element. Then a free surface that is compressed
//! along two directions folds element by element at a stretch of 0.745, however fine the mesh, in place of 0.666 (Biot),
//! and a wall of one element of degree 2 that bends is 15 % too soft. With 2 G it folds at 0.68, and bends within 5 %.
//!
//! Source: Simo, Taylor and Pister 1985, "Variational and projection methods for the volume
//! constraint in finite deformation elasto-plasticity", doi:10.1016/0045-7825(85)90033-7.

use std::sync::Arc;

use super::{Decoupled, Invariants, Kinematics, Material, Partials};
use crate::math::tensor::{Mat3, Mat9, add_j_hessian, vec9};

/// θ U'' at rest [G].
const POINTWISE: f64 = 2.0;

/// Strain of the differences that give derivatives of moduli at rest [1]: they are exact up to its square.
const STEP: f64 = 1e-5;

/// A law in two parts.
#[derive(Clone)]
pub struct Split {
    /// ψ_p, with all parameters of the law.
    pub pointwise: Arc<dyn Material>,
    /// A law that is U_m(J) at Ī₁ = Ī₂ = 3, with all parameters.
    volumetric: Arc<dyn Decoupled>,
}

impl Split {
    /// The two parts of a law, from the law and its U.
    pub(super) fn by_difference(law: impl Material + 'static, u: impl Decoupled + 'static) -> Self {
        let mean = MeanPart::new(&law, Arc::new(u));
        let pointwise = Arc::new(Difference { law, mean: mean.clone() });
        Self { pointwise, volumetric: Arc::new(mean) }
    }

    /// The two parts of a law that is U at Ī₁ = Ī₂ = 3.
    pub(super) fn of_decoupled(law: impl Decoupled + Clone + 'static) -> Self {
        let shared: Arc<dyn Decoupled> = Arc::new(law.clone());
        let mean = MeanPart::new(&law, shared.clone());
        let pointwise = Arc::new(DecoupledDifference { law: shared, mean: mean.clone() });
        Self { pointwise, volumetric: Arc::new(mean) }
    }

    /// U_m [J/m³], U_m' and U_m'' [Pa] at J − 1; infinite where J is not positive.
    pub fn volumetric(&self, j_minus_1: f64) -> [f64; 3] {
        derivatives(&*self.volumetric, j_minus_1)
    }

    /// Adds bar ∂U_m'/∂parameters at J − 1.
    pub fn add_volumetric_vjp(&self, j_minus_1: f64, bar: f64, out: &mut [f64]) {
        self.volumetric.add_partials_vjp(&ball(j_minus_1), [0.0, 0.0, bar], out);
    }
}

/// (1 − θ) U.
#[derive(Clone)]
struct MeanPart {
    u: Arc<dyn Decoupled>,
    /// 1 − θ.
    part: f64,
    /// Derivatives of 1 − θ by the parameters of the law.
    by: Vec<f64>,
}

impl MeanPart {
    fn new(law: &dyn Material, u: Arc<dyn Decoupled>) -> Self {
        let rest = Kinematics::new(&Mat3::zeros());
        // the row of F₁₀, the second of vec9
        let (shear, bulk) = (law.tangent(&rest)[(1, 1)], u.partials(&ball(0.0)).second[3]);
        let theta = POINTWISE * shear / bulk;
        let mut by = vec![0.0; law.parameter_count()];
        if theta >= 1.0 {
            return Self { u, part: 0.0, by };
        }
        let (mut by_shear, mut by_bulk) = (by.clone(), by.clone());
        for step in [STEP, -STEP] {
            let at = |value: f64| {
                let mut sheared = Mat3::zeros();
                sheared[(1, 0)] = value;
                sheared
            };
            law.add_parameter_vjp(&Kinematics::new(&at(step)), &at(0.5 / step), &mut by_shear);
            u.add_partials_vjp(&ball(step), [0.0, 0.0, 0.5 / step], &mut by_bulk);
        }
        for (by, (by_shear, by_bulk)) in by.iter_mut().zip(by_shear.iter().zip(by_bulk)) {
            *by = -theta * (by_shear / shear - by_bulk / bulk);
        }
        Self { u, part: 1.0 - theta, by }
    }

    /// Adds bar ∂(1 − θ)/∂parameters.
    fn add_part_vjp(&self, bar: f64, out: &mut [f64]) {
        out.iter_mut().zip(&self.by).for_each(|(out, by)| *out += bar * by);
    }
}

impl Decoupled for MeanPart {
    fn partials(&self, at: &Invariants) -> Partials {
        let Partials { value, first, second } = self.u.partials(at);
        let (first, second) = (first.map(|d| self.part * d), second.map(|d| self.part * d));
        Partials { value: self.part * value, first, second }
    }

    fn parameter_count(&self) -> usize {
        self.by.len()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        self.u.add_value_vjp(at, self.part * bar, out);
        self.add_part_vjp(bar * self.u.partials(at).value, out);
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        self.u.add_partials_vjp(at, bar.map(|bar| self.part * bar), out);
        let first = self.u.partials(at).first;
        self.add_part_vjp(bar.iter().zip(first).map(|(bar, d)| bar * d).sum(), out);
    }
}

/// A body that is as large as J says, and of the same shape as at rest.
fn ball(j_minus_1: f64) -> Invariants {
    let (j, log_j) = (1.0 + j_minus_1, j_minus_1.ln_1p());
    Invariants { a: 0.0, b: 0.0, j, log_j, j_minus_1 }
}

fn derivatives(volumetric: &dyn Decoupled, j_minus_1: f64) -> [f64; 3] {
    if j_minus_1 <= -1.0 {
        return [f64::INFINITY; 3];
    }
    let Partials { value, first, second } = volumetric.partials(&ball(j_minus_1));
    [value, first[2], second[3]]
}

/// ψ − U_m of a law in Ī₁, Ī₂ and J.
#[derive(Clone)]
struct DecoupledDifference {
    law: Arc<dyn Decoupled>,
    mean: MeanPart,
}

impl Decoupled for DecoupledDifference {
    fn partials(&self, at: &Invariants) -> Partials {
        let whole = self.law.partials(at);
        let mean = self.mean.partials(&Invariants { a: 0.0, b: 0.0, ..*at });
        let ([by_1, by_2, by_j], [a, b, c, d]) = (whole.first, whole.second);
        let first = [by_1, by_2, by_j - mean.first[2]];
        Partials { value: whole.value - mean.value, first, second: [a, b, c, d - mean.second[3]] }
    }

    fn parameter_count(&self) -> usize {
        self.law.parameter_count()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        self.law.add_value_vjp(at, bar, out);
        self.mean.add_value_vjp(&Invariants { a: 0.0, b: 0.0, ..*at }, -bar, out);
    }

    fn add_partials_vjp(&self, at: &Invariants, bar: [f64; 3], out: &mut [f64]) {
        self.law.add_partials_vjp(at, bar, out);
        let ball = Invariants { a: 0.0, b: 0.0, ..*at };
        self.mean.add_partials_vjp(&ball, [0.0, 0.0, -bar[2]], out);
    }
}

/// ψ − U_m of any law.
struct Difference<M> {
    law: M,
    mean: MeanPart,
}

impl<M: Material> Material for Difference<M> {
    fn energy_density(&self, k: &Kinematics) -> f64 {
        if k.j() <= 0.0 {
            return f64::INFINITY;
        }
        self.law.energy_density(k) - derivatives(&self.mean, k.j_minus_1)[0]
    }

    fn first_piola(&self, k: &Kinematics) -> Mat3 {
        self.law.first_piola(k) - derivatives(&self.mean, k.j_minus_1)[1] * k.cofactor
    }

    fn tangent(&self, k: &Kinematics) -> Mat9 {
        let [_, first, second] = derivatives(&self.mean, k.j_minus_1);
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
        self.mean.add_partials_vjp(&ball(k.j_minus_1), bar, out);
    }
}
