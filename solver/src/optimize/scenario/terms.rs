//! Values of the terms of the objective over a run, and their weights.

use std::collections::BTreeMap;

use measure::quantity::{Equilibrium, Forces, Partials, Quantity};
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
    let at = run.problem.iterate(&run.rest, &state.u, run.states.times[n]);
    let here = Equilibrium::new(&run.problem, &at, forces);
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

    /// Values of the terms over a run, without factors.
    pub fn values(&mut self, run: &Run) -> Vec<f64> {
        self.values_of(run, |_| true)
    }

    /// A run with its terms as they are weighted now.
    pub fn rated(&mut self, run: &Run) -> Run {
        let terms = self.terms_of(run);
        let kept = self.kept_of(run);
        Run { objective: terms.values().sum(), terms, kept, ..run.clone() }
    }

    /// Weighted terms over a run, by the user's names.
    fn terms_of(&mut self, run: &Run) -> BTreeMap<String, f64> {
        let values = self.values_of(run, |term| term.weight * term.factor != 0.0);
        let mut terms = BTreeMap::new();
        for (term, value) in self.terms.iter().zip(values) {
            *terms.entry(term.name.clone()).or_insert(0.0) += term.weight * term.factor * value;
        }
        terms
    }

    /// c of each bound at the end of a run.
    fn kept_of(&mut self, run: &Run) -> Vec<f64> {
        let end = run.states.steps();
        if self.bounds.is_empty() {
            return Vec::new();
        }
        let (forces, state) = (self.forces(run, end), run.states.state(end));
        let at = run.problem.iterate(&run.rest, &state.u, run.states.times[end]);
        let at = Equilibrium::new(&run.problem, &at, &forces);
        let one = |bound: &Bound| match bound.probe() {
            Some(probe) => bound.kept(probe.quantity.value(&at)),
            None => bound.kept(run.slope.unwrap_or(f64::NAN)),
        };
        self.bounds.iter().map(one).collect()
    }

    /// Values over a run of the terms that are wanted, zero of the others.
    fn values_of(&mut self, run: &Run, wanted: impl Fn(&Weighted) -> bool) -> Vec<f64> {
        let Run { problem, rest, states, .. } = run;
        let mut values = vec![0.0; self.terms.len()];
        for n in 0..=states.steps() {
            let (forces, state) = (self.forces(run, n), states.state(n));
            let at = problem.iterate(rest, &state.u, states.times[n]);
            let at = Equilibrium::new(problem, &at, &forces);
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
    pub(super) fn forces(&mut self, run: &Run, n: usize) -> Forces {
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
            let multipliers = solve_multipliers(problem, &mut self.workspace, &at);
            let at = Iterate { multipliers: &multipliers, ..at };
            forces.reaction = problem.gradient(&at).0;
        }
        forces
    }
}
