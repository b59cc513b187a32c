//! Softening of a body after a first stretch (Mullins effect): what it takes from the stress of the law
//! beside which it stands, by [`OgdenRoxburgh`], with the isochoric energy density W of that law.
//!
//! E(u; X, W_m) = ∫ D(W; W_m) dX      P = (η − 1) ∂W/∂F      ∂P/∂F = (η − 1) ∂²W/∂F² + η′ ∂W/∂F ⊗ ∂W/∂F
//!
//! with η′ = ∂η/∂W. Where W ≥ W_m all of it is zero. W_m at a point is the largest W at the ends of the time
//! steps so far, given during a step, so that a step has a potential:
//!
//! W_m = max(W_m°, W)
//!
//! A peak between two ends of steps is not seen. E has a kink in its second derivative at W = W_m, and W_m one in
//! its first: derivatives of a run hold where no point ends a step exactly there, as one would whose load is held.
//!
//! Its parameters are, in this order, the parameters of the law, r, m and β. Points are evaluated one after the other, without lanes;
//! before the first step has ended nothing is.
//!
//! Source: see [`OgdenRoxburgh`]; the potential of a step is ours.

use std::ops::Range;
use std::sync::Arc;

use super::quadrature_points::{Point, QuadraturePoints};
use super::{
    Energy, Hessian, InternalCotangent, InternalVariables, Iterate, Nature, Owner, PastCotangent,
    Slot, TimeStep,
};
use crate::element::FunctionSpace;
use crate::material::{Isochoric, Material, OgdenRoxburgh, Softened};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat3, Mat9, vec9};

/// Numbers of the law of softening.
const NUMBERS: usize = 3;

/// Softening of consecutive elements with one law.
#[derive(Clone)]
pub struct Mullins {
    /// What the user calls the body.
    pub name: String,
    law: Arc<Isochoric>,
    softening: OgdenRoxburgh,
    points: QuadraturePoints,
    /// Where its largest energy densities begin among the internal variables of all terms.
    first: usize,
}

/// How far a body is softened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MullinsSummary {
    /// Largest W_m [J/m³].
    pub largest_energy: f64,
    /// Smallest η at the state [1].
    pub factor: f64,
    /// Smallest η at rest after it [1].
    pub factor_at_rest: f64,
    /// Mean of η at rest over the volume [1].
    pub mean_factor_at_rest: f64,
    /// Work that is lost on the way to rest, of all inflations so far [J].
    pub lost: f64,
}

/// η of an element, as means over its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MullinsMean {
    /// At the state [1].
    pub factor: f64,
    /// At rest after it [1].
    pub factor_at_rest: f64,
}

impl Mullins {
    /// Who owns r, m and β of a body, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("mullins", place)
    }

    /// Softening of the isochoric part of a law; `first` is the number of internal variables of the
    /// terms before.
    pub fn new(
        law: Isochoric,
        softening: OgdenRoxburgh,
        elements: Range<usize>,
        first: usize,
    ) -> Self {
        let (name, points) = (String::new(), QuadraturePoints { elements });
        Self { name, law: Arc::new(law), softening, points, first }
    }

    /// The same of a body with a name.
    pub fn named(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }

    /// Number of parameters of the law, which come first.
    pub fn law_parameters(&self) -> usize {
        Material::parameter_count(&*self.law)
    }

    /// The elements.
    pub fn elements(&self) -> Range<usize> {
        self.points.elements.clone()
    }

    /// Measures of a state.
    pub fn summary(&self, at: &Iterate) -> MullinsSummary {
        let mut found = MullinsSummary {
            largest_energy: 0.0,
            factor: 1.0,
            factor_at_rest: 1.0,
            mean_factor_at_rest: 0.0,
            lost: 0.0,
        };
        let mut volume = 0.0;
        for [weight, largest, factor, at_rest] in self.states(at) {
            found.largest_energy = found.largest_energy.max(largest);
            found.factor = found.factor.min(factor);
            found.factor_at_rest = found.factor_at_rest.min(at_rest);
            found.mean_factor_at_rest += weight * at_rest;
            found.lost += weight * self.softening.at(0.0, largest).map_or(0.0, |at| at.value);
            volume += weight;
        }
        found.mean_factor_at_rest /= volume;
        found
    }

    /// η in each element.
    pub fn means(&self, at: &Iterate) -> Vec<MullinsMean> {
        let mean = |points: &[[f64; 4]]| {
            let volume: f64 = points.iter().map(|point| point[0]).sum();
            let of =
                |k: usize| points.iter().map(|point| point[0] * point[k]).sum::<f64>() / volume;
            MullinsMean { factor: of(2), factor_at_rest: of(3) }
        };
        self.states(at).chunks_exact(QuadraturePoints::each(at.space)).map(mean).collect()
    }

    /// Four numbers of each point: the volume that it stands for [m³], W_m [J/m³], η, and η at rest.
    fn states(&self, at: &Iterate) -> Vec<[f64; 4]> {
        let numbers = self.points.numbers(at, |point| {
            let (w, before) = (self.law.energy_density(&point.k), self.before(at.step, point));
            let largest = before.max(w);
            let factor = |w: f64| self.softening.factor(w, largest);
            [point.weight, largest, factor(w), factor(0.0)]
        });
        numbers.chunks_exact(4).map(|n| [n[0], n[1], n[2], n[3]]).collect()
    }

    /// W_m° at a point.
    fn before(&self, step: Option<&TimeStep>, point: &Point) -> f64 {
        let past = step.and_then(|step| step.internal.get(self.first + point.place));
        past.copied().unwrap_or(0.0)
    }

    /// D and its derivatives at a point, where it is softened.
    fn softened(&self, step: &TimeStep, point: &Point) -> Option<Softened> {
        self.softening.at(self.law.energy_density(&point.k), self.before(Some(step), point))
    }

    fn stress(&self, point: &Point, softened: &Softened) -> Mat3 {
        softened.first * self.law.first_piola(&point.k)
    }

    /// ∂P/∂F.
    fn tangent(&self, point: &Point, softened: &Softened) -> Mat9 {
        let by_f = vec9(&self.law.first_piola(&point.k));
        softened.first * self.law.tangent(&point.k) + softened.second * by_f * by_f.transpose()
    }
}

/// The step that leads to an iterate, if a body was stretched before it.
fn step_with_past<'a>(at: &Iterate<'a>) -> Option<&'a TimeStep> {
    at.step.filter(|step| !step.internal.is_empty())
}

/// The largest isochoric energy densities W_m [J/m³], one for each point.
impl InternalVariables for Mullins {
    fn count(&self, space: &FunctionSpace) -> usize {
        self.points.count(space)
    }

    fn values(&self, at: &Iterate) -> Vec<f64> {
        self.states(at).into_iter().map(|[_, largest, ..]| largest).collect()
    }

    fn add_vjp(
        &self,
        at: &Iterate,
        cotangents: &[f64],
        by_u: &mut [f64],
        by_rest: &mut [f64],
    ) -> InternalCotangent {
        let mut out = InternalCotangent {
            past: vec![0.0; self.count(at.space)],
            parameters: vec![0.0; self.law_parameters() + NUMBERS],
        };
        self.points.for_each(at, |e, element, point| {
            let bar = cotangents[self.first + point.place];
            if self.law.energy_density(&point.k) < self.before(at.step, point) {
                out.past[point.place] = bar;
                return;
            }
            self.law.add_energy_vjp(&point.k, bar, &mut out.parameters);
            let by_f = bar * self.law.first_piola(&point.k);
            let (place, by) = ((e, element), (&mut *by_u, &mut *by_rest));
            QuadraturePoints::add_deformation_vjp(at, place, point, &by_f, by);
        });
        out
    }
}

impl Energy for Mullins {
    fn kind(&self) -> (&'static str, Nature) {
        ("mullins", Nature::Elastic)
    }

    fn value(&self, at: &Iterate) -> f64 {
        let Some(step) = step_with_past(at) else { return 0.0 };
        let density = |point: &Point| self.softened(step, point).map_or(0.0, |by| by.value);
        self.points.integral(at, density)
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        let Some(step) = step_with_past(at) else { return };
        let stress = |point: &Point| self.softened(step, point).map(|by| self.stress(point, &by));
        self.points.add_gradient(at, stress, out);
    }

    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        let Some(step) = step_with_past(at) else { return };
        let tangent = |point: &Point| self.softened(step, point).map(|by| self.tangent(point, &by));
        self.points.add_hessian(at, kind, tangent, out);
    }

    fn internal_variables(&self) -> Option<&dyn InternalVariables> {
        Some(self)
    }

    fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let Some(step) = step_with_past(at) else { return };
        let at_point = |point: &Point| {
            let by = self.softened(step, point)?;
            Some((self.stress(point, &by), self.tangent(point, &by)))
        };
        self.points.add_mixed_vjp(at, lambda, at_point, out);
    }

    fn add_past_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut PastCotangent) {
        let Some(step) = step_with_past(at) else { return };
        out.internal.resize(step.internal.len(), 0.0);
        self.points.for_each(at, |_, element, point| {
            let Some(by) = self.softened(step, point) else { return };
            let along = self.law.first_piola(&point.k).dot(&point.gradient(element, lambda));
            out.internal[self.first + point.place] += point.weight * by.by_largest * along;
        });
    }

    fn slots(&self) -> Vec<Slot> {
        ["r", "m", "beta"].map(|key| Slot::new(key, if key == "m" { "Pa" } else { "1" })).to_vec()
    }

    fn parameter_vjp(&self, at: &Iterate, lambda: &[f64]) -> Vec<f64> {
        let law = self.law_parameters();
        let mut sum = vec![0.0; law + NUMBERS];
        let Some(step) = step_with_past(at) else { return sum };
        self.points.for_each(at, |_, element, point| {
            let Some(by) = self.softened(step, point) else { return };
            let bar = point.weight * point.gradient(element, lambda);
            let along = self.law.first_piola(&point.k).dot(&bar);
            let (own, numbers) = sum.split_at_mut(law);
            self.law.add_parameter_vjp(&point.k, &(by.first * bar), own);
            // P = (η − 1) ∂W/∂F depends on the parameters by η(W), too
            self.law.add_energy_vjp(&point.k, by.second * along, own);
            numbers.iter_mut().zip(by.by_numbers).for_each(|(n, by)| *n += by * along);
        });
        sum
    }
}
