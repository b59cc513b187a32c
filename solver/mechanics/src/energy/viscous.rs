//! Overstress of a viscoelastic body: Maxwell branches beside its law, a Prony series on the
//! isochoric part ψ̄(Ī₁, Ī₂) = ψ(Ī₁, Ī₂, J) − ψ(3, 3, J) of that.
//!
//! A branch of overstress γ and relaxation time τ carries γ (S − Z): S = 2 ∂ψ̄/∂C is the isochoric
//! stress (second Piola–Kirchhoff), and Z follows it, τ Ż = S − Z, from 0 at rest. The law alone is
//! what is left after a long time; at once the isochoric part is 1 + Σ γ times as stiff.
//!
//! With the formula of the time step, Ż = (Z − Z°) / h and a = h/τ, from what the relaxed stresses of the
//! last states make, Z°:
//!
//! Z = (Z° + a S) / (1 + a)        γ (S − Z) = c (S − Z°),  c = γ / (1 + a)
//!
//! Z° is given during the step, so that the overstress has an incremental potential:
//!
//! E(u; X, Z°) = ∫ Σ c (ψ̄(F) − Z° : E) dX        E = ½ (FᵀF − I)
//! P = Σ c (P̄ − F Z°)                            ∂P/∂F = Σ c (∂P̄/∂F − I ⊗ Z°)
//!
//! Without a step in time E is zero. Stresses Z are six numbers (xx, yy, zz, yz, zx, xy) for each
//! quadrature point, branch after branch, element after element. Where strain is constant in an
//! element, one point stands for all.
//!
//! Its parameters are those of the law, then γ and τ of each branch.
//!
//! Source: Simo 1987, "On a fully three-dimensional finite-strain viscoelastic damage model",
//! doi:10.1016/0045-7825(87)90107-1; Holzapfel, "Nonlinear Solid Mechanics", section 6.10. The
//! backward formula in place of their exponential one is ours: it is that of the velocities.

use std::ops::Range;
use std::sync::Arc;

use super::quadrature_points::{Point, QuadraturePoints};
use super::{
    Energy, Hessian, InternalCotangent, InternalVariables, Iterate, Nature, Owner, PastCotangent,
    Slot, TimeStep,
};
use crate::element::FunctionSpace;
use crate::material::{Isochoric, Material};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat3, Mat9, vec9};

/// Numbers of a symmetric tensor.
const SIX: usize = 6;
/// Their rows and columns.
const PLACES: [(usize, usize); SIX] = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];

/// One term of the Prony series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// γ: isochoric stress at once, as a part of that of the law [1].
    pub overstress: f64,
    /// τ: after which 1/e of it is left [s].
    pub time: f64,
}

/// Overstress of consecutive elements with one law.
#[derive(Clone)]
pub struct Viscous {
    law: Arc<Isochoric>,
    branches: Vec<Branch>,
    points: QuadraturePoints,
    /// Where its relaxed stresses begin among those of all terms.
    first: usize,
}

fn tensor(six: &[f64]) -> Mat3 {
    let mut tensor = Mat3::zeros();
    for (&(i, j), value) in PLACES.iter().zip(six) {
        tensor[(i, j)] = *value;
        tensor[(j, i)] = *value;
    }
    tensor
}

/// The derivative by the six numbers of a symmetric tensor, from that by its nine.
fn by_six(m: &Mat3) -> [f64; SIX] {
    PLACES.map(|(i, j)| if i == j { m[(i, i)] } else { m[(i, j)] + m[(j, i)] })
}

/// The symmetric derivative by nine, from that by six.
fn by_nine(six: &[f64]) -> Mat3 {
    tensor(six).map_with_location(|i, j, v| if i == j { v } else { 0.5 * v })
}

impl Viscous {
    /// Who owns overstress and time of each branch of a body, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("relaxation", place)
    }

    /// Branches beside the isochoric part of a law; `first` is the number of relaxed stresses of
    /// the terms before.
    pub fn new(
        law: Isochoric,
        branches: Vec<Branch>,
        elements: Range<usize>,
        first: usize,
    ) -> Self {
        Self { law: Arc::new(law), branches, points: QuadraturePoints { elements }, first }
    }

    /// Number of parameters of the law, which come first.
    pub fn law_parameters(&self) -> usize {
        Material::parameter_count(&*self.law)
    }

    /// Where the stress of a branch at a point lies among those of all terms.
    fn at(&self, count: usize, branch: usize, place: usize) -> Range<usize> {
        let start = self.first + SIX * (branch * count + place);
        start..start + SIX
    }

    /// Each branch: c, and Z° at a point.
    fn branches_at(
        &self,
        step: &TimeStep,
        count: usize,
        place: usize,
    ) -> impl Iterator<Item = (f64, Mat3)> {
        self.branches.iter().enumerate().map(move |(i, branch)| {
            let past = step.internal.get(self.at(count, i, place));
            (
                branch.overstress / (1.0 + step.internal_h / branch.time),
                past.map_or(Mat3::zeros(), tensor),
            )
        })
    }

    /// Σ c and Σ c Z° at a point.
    fn sums(&self, step: &TimeStep, count: usize, place: usize) -> (f64, Mat3) {
        let mut sums = (0.0, Mat3::zeros());
        for (c, past) in self.branches_at(step, count, place) {
            sums.0 += c;
            sums.1 += c * past;
        }
        sums
    }

    fn stress(&self, point: &Point, (c, past): &(f64, Mat3)) -> Mat3 {
        *c * self.law.first_piola(&point.k) - point.k.f * past
    }

    /// ∂P/∂F.
    fn tangent(&self, point: &Point, (c, past): &(f64, Mat3)) -> Mat9 {
        *c * self.law.tangent(&point.k) - past.kronecker(&Mat3::identity())
    }

    /// S.
    fn isochoric_stress(&self, point: &Point) -> Mat3 {
        point.inverse() * self.law.first_piola(&point.k)
    }
}

/// The relaxed stresses [Pa], six for each point of each branch.
impl InternalVariables for Viscous {
    fn count(&self, space: &FunctionSpace) -> usize {
        SIX * self.branches.len() * self.points.count(space)
    }

    fn values(&self, iterate: &Iterate) -> Vec<f64> {
        let step = iterate.step.expect("stresses relax in a step in time");
        let count = self.points.count(iterate.space);
        let stresses = self.points.numbers(iterate, |point| {
            let s = self.isochoric_stress(point);
            PLACES.map(|place| s[place])
        });
        let of_branch = |(i, branch): (usize, &Branch)| -> Vec<f64> {
            let a = step.internal_h / branch.time;
            let begin = self.at(count, i, 0).start;
            let past = |k: usize| step.internal.get(begin + k).copied().unwrap_or(0.0);
            stresses.iter().enumerate().map(|(k, s)| (past(k) + a * s) / (1.0 + a)).collect()
        };
        self.branches.iter().enumerate().flat_map(of_branch).collect()
    }

    fn add_vjp(
        &self,
        iterate: &Iterate,
        cotangents: &[f64],
        by_u: &mut [f64],
        by_rest: &mut [f64],
    ) -> InternalCotangent {
        let step = iterate.step.expect("stresses relax in a step in time");
        let count = self.points.count(iterate.space);
        let mut out = InternalCotangent {
            past: vec![0.0; self.count(iterate.space)],
            parameters: vec![0.0; self.law_parameters() + 2 * self.branches.len()],
        };
        self.points.for_each(iterate, |e, element, point| {
            let (s, inverse) = (self.isochoric_stress(point), point.inverse());
            let mut s_bar = Mat3::zeros();
            for (i, branch) in self.branches.iter().enumerate() {
                let place = self.at(count, i, point.place);
                let (bar, a) = (&cotangents[place.clone()], step.internal_h / branch.time);
                let past = step.internal.get(place.clone()).map_or(Mat3::zeros(), tensor);
                let to = place.start - self.first;
                out.past[to..to + SIX].iter_mut().zip(bar).for_each(|(p, b)| *p = b / (1.0 + a));
                let bar = by_nine(bar);
                s_bar += a / (1.0 + a) * bar;
                // ∂Z/∂τ = −a/τ (S − Z°)/(1 + a)²
                out.parameters[self.law_parameters() + 2 * i + 1] -=
                    a / branch.time / (1.0 + a).powi(2) * bar.dot(&(s - past));
            }
            // S = F⁻¹ P̄: δS = F⁻¹ (δP̄ − δF S)
            let pushed = inverse.transpose() * s_bar;
            self.law.add_parameter_vjp(&point.k, &pushed, &mut out.parameters);
            let through = self.law.tangent(&point.k) * vec9(&pushed);
            let by_f = Mat3::from_column_slice(through.as_slice()) - pushed * s;
            let (at, by) = ((e, element), (&mut *by_u, &mut *by_rest));
            QuadraturePoints::add_deformation_vjp(iterate, at, point, &by_f, by);
        });
        out
    }
}

impl Energy for Viscous {
    fn kind(&self) -> (&'static str, Nature) {
        ("viscous", Nature::Dissipative)
    }

    fn value(&self, iterate: &Iterate) -> f64 {
        let Some(step) = iterate.step else { return 0.0 };
        let count = self.points.count(iterate.space);
        self.points.integral(iterate, |point| {
            let (c, past) = self.sums(step, count, point.place);
            c * self.law.energy_density(&point.k) - past.dot(&point.k.green)
        })
    }

    fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
        let Some(step) = iterate.step else { return };
        let count = self.points.count(iterate.space);
        let stress = |point: &Point| Some(self.stress(point, &self.sums(step, count, point.place)));
        self.points.add_gradient(iterate, stress, out);
    }

    fn add_hessian(&self, iterate: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        let Some(step) = iterate.step else { return };
        let count = self.points.count(iterate.space);
        let tangent =
            |point: &Point| Some(self.tangent(point, &self.sums(step, count, point.place)));
        self.points.add_hessian(iterate, kind, tangent, out);
    }

    fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let Some(step) = iterate.step else { return };
        let count = self.points.count(iterate.space);
        let at_point = |point: &Point| {
            let sums = self.sums(step, count, point.place);
            Some((self.stress(point, &sums), self.tangent(point, &sums)))
        };
        self.points.add_mixed_vjp(iterate, lambda, at_point, out);
    }

    fn internal_variables(&self) -> Option<&dyn InternalVariables> {
        Some(self)
    }

    fn add_past_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut PastCotangent) {
        let Some(step) = iterate.step.filter(|step| !step.internal.is_empty()) else { return };
        out.internal.resize(step.internal.len(), 0.0);
        let count = self.points.count(iterate.space);
        self.points.for_each(iterate, |_, element, point| {
            let grad_l = point.gradient(element, lambda);
            let by = by_six(&(-point.weight * (point.k.f.transpose() * grad_l)));
            for (i, (c, _)) in self.branches_at(step, count, point.place).enumerate() {
                let to = &mut out.internal[self.at(count, i, point.place)];
                to.iter_mut().zip(by).for_each(|(to, by)| *to += c * by);
            }
        });
    }

    fn slots(&self) -> Vec<Slot> {
        let of_branch = |i: usize| {
            [("overstress", "1"), ("time", "s")]
                .map(|(key, unit)| Slot::new(&format!("{i}.{key}"), unit))
        };
        (1..=self.branches.len()).flat_map(of_branch).collect()
    }

    fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let law = self.law_parameters();
        let mut sum = vec![0.0; law + 2 * self.branches.len()];
        let Some(step) = iterate.step else { return sum };
        let count = self.points.count(iterate.space);
        self.points.for_each(iterate, |_, element, point| {
            let bar = point.weight * point.gradient(element, lambda);
            let (c, _) = self.sums(step, count, point.place);
            self.law.add_parameter_vjp(&point.k, &(c * bar), &mut sum[..law]);
            let stress = self.law.first_piola(&point.k);
            let branches = self.branches_at(step, count, point.place);
            for (i, ((c, past), branch)) in branches.zip(&self.branches).enumerate() {
                let along = (stress - point.k.f * past).dot(&bar);
                let a = step.internal_h / branch.time;
                sum[law + 2 * i] += along / (1.0 + a);
                // ∂c/∂τ = c a / (τ (1 + a))
                sum[law + 2 * i + 1] += c * a / (branch.time * (1.0 + a)) * along;
            }
        });
        sum
    }
}
