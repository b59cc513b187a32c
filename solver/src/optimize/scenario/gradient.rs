//! The gradient of the objective of a run, backwards through its time steps.

use measure::quantity::{Equilibrium, Forces, Partials};
use mechanics::adjoint::{self, Gradient, Wanted};
use mechanics::body::Body;
use mechanics::element::FunctionSpace;
use mesh::Vec3;
use scene::Weighted;

use super::terms::add_partials;
use super::{Bound, Rejected, Run, Scenario};

impl Scenario {
    /// dJ of all terms, of those of a name, or dc of a bound of a name, times a factor, by all that a run depends on, the designed rest
    /// shape among it. Where it is linearised at the run, that saves factorisations.
    pub fn sweep(
        &mut self,
        run: &Run,
        designed: &[Vec3],
        body: &Body,
        wanted: Wanted,
        (of, factor): (Option<&str>, f64),
    ) -> Result<Gradient, Rejected> {
        let (rest, states) = (&run.rest[..], &*run.states);
        let forces: Vec<Forces> = (0..=states.steps()).map(|n| self.forces(run, n)).collect();
        let mut by_rest = vec![0.0; 3 * rest.len()];
        let terms = chosen(&self.terms, &self.bounds, of);
        let partials = |_: &FunctionSpace, n: usize, out: &mut adjoint::Partials| {
            let adjoint::Partials { by_u, by_contact, by_reaction } = out;
            let (u, contact, reaction) = (by_u, by_contact, by_reaction);
            let mut out = Partials { u, rest: &mut by_rest, contact, reaction };
            add_partials(terms.iter().copied(), run, n, &forces[n], factor, &mut out);
        };
        let (problem, workspace) = (&*run.problem, &mut self.workspace);
        let known = run.linearized(self.linearized.as_ref());
        let on = (rest, states);
        let swept = adjoint::sweep_for(problem, workspace, on, &known, wanted, partials);
        let mut gradient = swept.map_err(|e| self.reject(e))?;
        gradient.rest.iter_mut().zip(&by_rest).for_each(|(g, b)| *g += b);
        self.add_by_parameters(run, &forces, of, factor, &mut gradient);
        if self.bounds.iter().any(|bound| bound.is_slope() && of == Some(&*bound.name)) {
            self.add_slope(run, factor, &mut gradient)?;
        }
        if let Some(offset) = &self.offset {
            offset.add_vjp(designed, &mut gradient.rest);
        }
        for plane in &body.planes {
            // no shape moves them there
            plane.vertices().iter().for_each(|v| gradient.rest[3 * v + plane.axis] = 0.0);
        }
        Ok(gradient)
    }

    /// Adds the partial derivatives of terms by the parameters that they are made with, in each time step.
    fn add_by_parameters(
        &self,
        run: &Run,
        forces: &[Forces],
        of: Option<&str>,
        factor: f64,
        gradient: &mut Gradient,
    ) {
        let Run { problem, rest, states, .. } = run;
        for (n, forces) in forces.iter().enumerate().skip(1) {
            let state = states.state(n);
            let at = problem.iterate(rest, &state.u, states.times[n]);
            let here = Equilibrium::new(problem, &at, forces);
            for term in chosen(&self.terms, &self.bounds, of) {
                let factor = factor * term.weight * term.factor * term.factors[n];
                for (id, by) in term.quantity.by_parameters(&here, factor) {
                    gradient.parameters.add(n - 1, id, by);
                }
            }
        }
    }

    /// dJ by the variables of the loads, which have these values.
    pub fn by_loads(&self, loads: &[f64], gradient: &Gradient) -> Vec<f64> {
        self.loads.vjp(loads, &self.swept(gradient))
    }
}

/// All terms, or the terms and the bound of a name.
fn chosen<'a>(terms: &'a [Weighted], bounds: &'a [Bound], of: Option<&str>) -> Vec<&'a Weighted> {
    let Some(name) = of else { return terms.iter().collect() };
    let bounds = bounds.iter().filter_map(Bound::probe);
    terms.iter().chain(bounds).filter(|term| term.name == name).collect()
}
