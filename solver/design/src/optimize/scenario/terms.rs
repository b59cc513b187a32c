//! Values of the terms of the objective over a run, and their weights.

use std::collections::BTreeMap;

use measure::quantity::{Forces, Partials, Quantity};
use mechanics::energy::Iterate;
use mechanics::forward::solve_multipliers;
use scene::Weighted;

use super::{Bound, Run, Scenario};

/// Adds the partial derivatives of some terms, times a factor, by what they look at in a moment.
pub(super) fn add_partials<'a>(
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
    pub(super) fn forces(&self, run: &Run, n: usize) -> Forces {
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
}
