//! The terms of the objective over a run: their values, weights and gradient, backwards through the time steps, and their
//! curvature along first-order changes of the run.

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::Result;
use measure::quantity::{Forces, Partials, Quantity};
use mechanics::adjoint::{self, Gradient, Wanted};
use mechanics::element::FunctionSpace;
use mechanics::energy::Iterate;
use mechanics::forward::{Trajectory, Varied, neighbours, solve_multipliers};
use mesh::Vec3;
use nalgebra::DMatrix;
use scene::Weighted;
use variables::vectors::{difference, products};

use super::{Bound, Rejected, Run, Scenario};

/// Adds the partial derivatives of some terms, times a factor, by what they look at in a moment.
fn add_partials<'a>(
    terms: impl Iterator<Item = &'a Weighted>,
    run: &Run,
    n: usize,
    forces: &Forces,
    factor: f64,
    out: &mut Partials,
) {
    let state = run.states.state(n);
    let here = run.equilibrium(n, &state, forces);
    for term in terms {
        let factor = factor * term.weight * term.factor * term.factors[n];
        if factor != 0.0 {
            term.quantity.add_partials(&here, factor, out);
        }
    }
}

impl Scenario {
    /// Factors of the terms, in the order of the design file.
    pub fn weights(&self) -> Vec<f64> {
        self.terms.iter().map(|term| term.weight).collect()
    }

    /// Gives the terms these factors.
    pub fn set_weights(&mut self, weights: &[f64]) {
        self.terms.iter_mut().zip(weights).for_each(|(term, weight)| term.weight = *weight);
    }

    /// A run with its terms as they are weighted now.
    pub fn rated(&self, run: &Run) -> Run {
        let values = self.values(run, |term| term.weight * term.factor != 0.0);
        let mut terms = BTreeMap::new();
        for (term, value) in self.terms.iter().zip(values) {
            *terms.entry(term.name.clone()).or_insert(0.0) += term.weight * term.factor * value;
        }
        Run { objective: terms.values().sum(), terms, kept: self.kept(run), ..run.clone() }
    }

    /// c of each bound at the end of a run.
    fn kept(&self, run: &Run) -> Vec<f64> {
        if self.bounds.is_empty() {
            return Vec::new();
        }
        let end = run.states.steps();
        let (state, forces) = (run.states.state(end), self.forces(run, end));
        let at = run.equilibrium(end, &state, &forces);
        let one = |bound: &Bound| match bound.probe() {
            Some(probe) => bound.kept(probe.quantity.value(&at)),
            None => bound.kept(run.slope.unwrap_or(f64::NAN)),
        };
        self.bounds.iter().map(one).collect()
    }

    /// Values over a run of the terms that are wanted, without weights; zero of the others.
    pub fn values(&self, run: &Run, wanted: impl Fn(&Weighted) -> bool) -> Vec<f64> {
        let mut values = vec![0.0; self.terms.len()];
        for n in 0..=run.states.steps() {
            let (forces, state) = (self.forces(run, n), run.states.state(n));
            let at = run.equilibrium(n, &state, &forces);
            for (term, value) in self.terms.iter().zip(&mut values) {
                let factor = term.factors[n];
                if factor != 0.0 && wanted(term) {
                    *value += factor * term.quantity.value(&at);
                }
            }
        }
        values
    }

    /// Forces on the nodes at a moment, where a term looks at them; at t = 0 there are none.
    fn forces(&self, run: &Run, n: usize) -> Forces {
        let Run { problem, rest, states, .. } = run;
        let looks = |uses: fn(&dyn Quantity) -> bool| {
            let bounds = self.bounds.iter().filter_map(Bound::probe);
            self.terms.iter().chain(bounds).any(|t| t.factors[n] != 0.0 && uses(&*t.quantity))
        };
        let (uses_contact, uses_reaction) =
            (looks(|q| q.uses_contact()), looks(|q| q.uses_reaction()));
        let none = |wanted: bool| if wanted { vec![0.0; problem.dofs()] } else { Vec::new() };
        let mut forces = Forces { contact: none(uses_contact), reaction: none(uses_reaction) };
        if n == 0 || !uses_contact && !uses_reaction {
            return forces;
        }
        let (state, step) = (states.state(n), states.step(problem, rest, n));
        let at = problem.iterate(rest, &state.u, states.times[n]);
        let at = Iterate { step: Some(&step), ..at };
        if uses_contact {
            forces.contact = problem.energies.contact_forces(&at);
        }
        if uses_reaction {
            let multipliers = solve_multipliers(problem, &mut self.workspaces().equilibrium, &at);
            let at = Iterate { multipliers: &multipliers, ..at };
            forces.reaction = problem.gradient(&at).0;
        }
        forces
    }

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

    /// A small change of the designed shape and of the variables of the loads.
    pub fn varied(&self, loads: &[f64], designed: &[Vec3]) -> Result<Varied, Rejected> {
        Ok(Varied { problem: self.under(loads)?, rest: self.rest(designed) })
    }

    /// dᵢᵀ ∇²J dⱼ of each two first-order changes d of what the terms of the objective J look at, from a run to its
    /// neighbours. It is the matrix of Gauss and Newton, with the curvature of the terms themselves. The states of the
    /// neighbours come with it. None where the run has no usable tangent.
    pub fn curvature(
        &self,
        run: &Run,
        varied: &[Varied],
    ) -> Option<(DMatrix<f64>, Vec<Arc<Trajectory>>)> {
        let of = (&run.rest[..], &*run.states);
        let begin = (&self.start, self.state_memory / varied.len() as f64);
        let all = neighbours(
            &run.problem,
            &mut self.workspaces().equilibrium,
            of,
            &run.tangents,
            varied,
            begin,
        )?;
        let as_run = |(varied, states): (&Varied, _)| Run {
            problem: Arc::clone(&varied.problem),
            rest: varied.rest.clone(),
            states: Arc::new(states),
            ..run.clone()
        };
        let all: Vec<Run> = varied.iter().zip(all).map(as_run).collect();
        let mut curvature = DMatrix::zeros(all.len(), all.len());
        for n in 0..=run.states.steps() {
            if self.terms.iter().all(|term| term.weight * term.factor * term.factors[n] == 0.0) {
                continue;
            }
            let (here, slope) = self.seen(run, n);
            let (mut changes, mut bends) = (Vec::new(), Vec::new());
            for other in &all {
                let (there, other_slope) = self.seen(other, n);
                changes.push(difference(&there, &here));
                bends.push(difference(&other_slope, &slope));
            }
            curvature += products(&bends, &changes);
        }
        let states = all.into_iter().map(|run| run.states).collect();
        Some((0.5 * (&curvature + curvature.transpose()), states))
    }

    /// The run at other loads and another shape, foreseen by the states of neighbours: for each of them, with how much
    /// of its difference from the run is added.
    pub fn foreseen(
        &self,
        run: &Run,
        neighbours: &[(f64, &Trajectory)],
        loads: &[f64],
        designed: &[Vec3],
    ) -> Result<Trajectory> {
        let displacement = |n: usize| {
            let here = run.states.state(n);
            let mut u = here.u.clone();
            for (part, states) in neighbours {
                let there = states.state(n);
                let pairs = u.iter_mut().zip(&here.u).zip(&there.u);
                pairs.for_each(|((u, here), there)| *u += part * (there - here));
            }
            u
        };
        let all = (1..=run.states.steps()).map(|n| (run.states.times[n], Ok(displacement(n))));
        self.states::<anyhow::Error>(loads, designed, all)
    }

    /// What terms look at in a moment of a run, (u, X, f, r) one after the other, and their derivatives by it.
    fn seen(&self, run: &Run, n: usize) -> (Vec<f64>, Vec<f64>) {
        let forces = self.forces(run, n);
        let Forces { contact, reaction } = &forces;
        let rest: Vec<f64> = run.rest.iter().flat_map(|x| [x.x, x.y, x.z]).collect();
        let all = [&run.states.state(n).u[..], &rest, contact, reaction].concat();
        let mut slope = vec![0.0; all.len()];
        let (u, others) = slope.split_at_mut(run.problem.dofs());
        let (rest, others) = others.split_at_mut(rest.len());
        let (contact, reaction) = others.split_at_mut(contact.len());
        let mut out = Partials { u, rest, contact, reaction };
        add_partials(self.terms.iter(), run, n, &forces, 1.0, &mut out);
        (all, slope)
    }
}
