//! Terms that remember: any with [`InternalVariables`] has its gradient through time.

use super::*;
use crate::energy::{
    Energy, Hessian, InternalCotangent, InternalVariables, Nature, PastCotangent, TimeStep,
};
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::Mat3;

/// Stiffness of a Maxwell element at each degree of freedom [N/m], and its time [s].
const STIFFNESS: f64 = 0.3;
const TIME: f64 = 0.05;

/// A spring and a dashpot in series from each node to where it was at rest:
///
/// Ż = (u − Z) / τ     E = ½ c |u − Z°|², c = k / (1 + h/τ)     Z = (Z° + (h/τ) u) / (1 + h/τ)
struct Maxwell {
    /// Where its variables begin among those of all terms.
    first: usize,
}

impl Maxwell {
    /// 1 + h/τ, and u − Z°.
    fn stretch(&self, at: &Iterate) -> Option<(f64, Vec<f64>)> {
        let step = at.step?;
        let from = |d: usize| self.past(step, d);
        let stretch = at.u.iter().enumerate().map(|(d, u)| u - from(d)).collect();
        Some((1.0 + step.internal_h / TIME, stretch))
    }

    fn past(&self, step: &TimeStep, d: usize) -> f64 {
        step.internal.get(self.first + d).copied().unwrap_or(0.0)
    }
}

impl Energy for Maxwell {
    fn name(&self) -> &'static str {
        "maxwell"
    }

    fn nature(&self) -> Nature {
        Nature::Other
    }

    fn value(&self, at: &Iterate) -> f64 {
        self.stretch(at).map_or(0.0, |(a, d)| 0.5 * STIFFNESS / a * dot(&d, &d))
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        let Some((a, stretch)) = self.stretch(at) else { return };
        out.iter_mut().zip(stretch).for_each(|(out, d)| *out += STIFFNESS / a * d);
    }

    fn add_hessian(&self, at: &Iterate, _: Hessian, out: &mut BlockMatrix) {
        let Some((a, _)) = self.stretch(at) else { return };
        let c = STIFFNESS / a;
        for node in 0..at.space.node_count() {
            out.add_lower(node, node, &(c * Mat3::identity()));
        }
    }

    fn internal_variables(&self) -> Option<&dyn InternalVariables> {
        Some(self)
    }

    fn add_mixed_vjp(&self, _: &Iterate, _lambda: &[f64], _out: &mut [f64]) {}

    fn add_past_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut PastCotangent) {
        let Some((a, _)) = self.stretch(at) else { return };
        out.internal.resize(self.first + lambda.len(), 0.0);
        let own = out.internal[self.first..].iter_mut();
        own.zip(lambda).for_each(|(out, l)| *out -= STIFFNESS / a * l);
    }
}

impl InternalVariables for Maxwell {
    fn count(&self, space: &FunctionSpace) -> usize {
        3 * space.node_count()
    }

    fn values(&self, at: &Iterate) -> Vec<f64> {
        let step = at.step.expect("through time");
        let a = step.internal_h / TIME;
        let value = |(d, u): (usize, &f64)| (self.past(step, d) + a * u) / (1.0 + a);
        at.u.iter().enumerate().map(value).collect()
    }

    fn add_vjp(
        &self,
        at: &Iterate,
        cotangents: &[f64],
        by_u: &mut [f64],
        _by_rest: &mut [f64],
    ) -> InternalCotangent {
        let a = at.step.expect("through time").internal_h / TIME;
        let own = &cotangents[self.first..self.first + by_u.len()];
        by_u.iter_mut().zip(own).for_each(|(by, bar)| *by += a / (1.0 + a) * bar);
        let past = own.iter().map(|bar| bar / (1.0 + a)).collect();
        InternalCotangent { past, parameters: Vec::new() }
    }
}

/// Beside a viscous body, whose variables come first.
#[test]
fn a_term_of_a_user_remembers_and_has_its_gradient() {
    for method in [Method::Quasistatic, Method::Bdf2, Method::Newmark] {
        let (body, inside) = (Shape::Tet, Inside::Pressure);
        let case = Case { method, degree: 1, steps: 4, dt: 0.02, body, inside };
        let problem = || {
            let (mut problem, _, rest) = viscous::problem(&case, &NUMBERS, &viscous::BRANCHES);
            let first = problem.energies.internal_count(&problem.space);
            problem.energies = problem.energies.with(Maxwell { first });
            let workspace = Workspace::new(&problem);
            (problem, workspace, rest)
        };
        let (own, mut workspace, rest) = problem();
        let start = case.start(&own, &rest);
        let run = case.run(&own, &mut workspace, &rest, start.clone());
        assert_eq!(run.state(4).internal.len(), own.energies.internal_count(&own.space));
        let probe = Probe::new(own.dofs(), false);
        let gradient = probe.gradient(&own, &mut workspace, &rest, &run);
        check_gradient(&flat(&rest), &gradient.rest, 2e-6, |x| {
            let (problem, mut workspace, _) = problem();
            let rest = points(x);
            let run = case.run(&problem, &mut workspace, &rest, start.clone());
            probe.value(&problem, &rest, &run)
        });
    }
}
