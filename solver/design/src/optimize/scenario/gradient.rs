//! The gradient of the objective of a run, backwards through its time steps.

use measure::quantity::{Forces, Partials};
use mechanics::adjoint::{self, Gradient, Wanted};
use mechanics::element::FunctionSpace;
use mesh::Vec3;
use scene::Weighted;

use super::terms::add_partials;
use super::{Bound, Rejected, Run, Scenario};

impl Scenario {
    /// dJ of all terms, of those of a name, or dc of a bound of a name, times a factor, by all that a run depends on, the designed rest
    /// shape among it. Where the run is linearised, that saves factorisations.
    pub fn sweep(
        &self,
        run: &Run,
        designed: &[Vec3],
        wanted: Wanted,
        (of, factor): (Option<&str>, f64),
    ) -> Result<Gradient, Rejected> {
        let (rest, states) = (&run.rest[..], &*run.states);
        let moments = 0..=states.steps();
        let forces: Vec<Forces> = moments.map(|n| self.forces(run, n)).collect();
        let mut by_rest = vec![0.0; 3 * rest.len()];
        let terms = self.chosen(of);
        let partials = |_: &FunctionSpace, n: usize, out: &mut adjoint::Partials| {
            let adjoint::Partials { by_u, by_contact, by_reaction } = out;
            let (u, contact, reaction) = (by_u, by_contact, by_reaction);
            let mut out = Partials { u, rest: &mut by_rest, contact, reaction };
            add_partials(terms.iter().copied(), run, n, &forces[n], factor, &mut out);
        };
        let (problem, on) = (&*run.problem, (rest, states));
        let swept = {
            let workspace = &mut self.workspaces().equilibrium;
            adjoint::sweep(problem, workspace, on, &run.tangents, wanted, partials)
        };
        let mut gradient = swept.map_err(|e| self.reject(e))?;
        gradient.rest.iter_mut().zip(&by_rest).for_each(|(g, b)| *g += b);
        for (n, forces) in forces.iter().enumerate().skip(1) {
            let state = states.state(n);
            let here = run.equilibrium(n, &state, forces);
            for term in &terms {
                // parameters that the terms are made with
                let factor = factor * term.weight * term.factor * term.factors[n];
                for (id, by) in term.quantity.by_parameters(&here, factor) {
                    gradient.parameters.add(n - 1, id, by);
                }
            }
        }
        if self.bounds.iter().any(|bound| bound.is_slope() && of == Some(&*bound.name)) {
            self.add_slope(run, factor, &mut gradient)?;
        }
        if let Some(walls) = &self.walls {
            walls.add_vjp(designed, &self.config.walls(), &mut gradient.rest);
        }
        for plane in &self.body.planes {
            // no shape moves them there
            plane.vertices().iter().for_each(|v| gradient.rest[3 * v + plane.axis] = 0.0);
        }
        Ok(gradient)
    }

    /// dJ by the variables of the loads, which have these values.
    pub fn by_loads(&self, loads: &[f64], gradient: &Gradient) -> Vec<f64> {
        self.loads.vjp(loads, &self.swept(gradient))
    }

    /// All terms, or the terms and the bound of a name.
    fn chosen(&self, of: Option<&str>) -> Vec<&Weighted> {
        let Some(name) = of else { return self.terms.iter().collect() };
        let bounds = self.bounds.iter().filter_map(Bound::probe);
        self.terms.iter().chain(bounds).filter(|term| term.name == name).collect()
    }
}
