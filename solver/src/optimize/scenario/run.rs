//! A run of a scenario.

use std::collections::BTreeMap;
use std::sync::Arc;

use mechanics::energy::Iterate;
use mechanics::forward::{Linearizations, Problem, Trajectory};
use mesh::Vec3;

/// A run and its objective.
#[derive(Clone)]
pub struct Run {
    /// What was solved: the scenario with the designed loads.
    pub problem: Arc<Problem>,
    /// Rest vertex positions, with walls that are off [m].
    pub rest: Vec<Vec3>,
    /// All states.
    pub states: Arc<Trajectory>,
    /// The slope of the pressure at its end [1], where it is kept.
    pub slope: Option<f64>,
    /// Σ of the terms.
    pub objective: f64,
    /// Weighted value of each term, by the user's name.
    pub terms: BTreeMap<String, f64>,
    /// c of each bound, which is to be 0 or more, in its unit.
    pub kept: Vec<f64>,
    /// Newton iterations.
    pub newton_iterations: usize,
}

impl Run {
    /// What was linearised last, with the states at whose ends it was, if they are those of this run.
    pub(super) fn linearized(
        &self,
        last: Option<&(Arc<Trajectory>, Arc<Linearizations>)>,
    ) -> Arc<Linearizations> {
        let known = last.filter(|(states, _)| Arc::ptr_eq(states, &self.states));
        known.map(|(_, known)| Arc::clone(known)).unwrap_or_default()
    }

    /// Looks at the end of the run.
    pub(super) fn at_end<T>(&self, look: impl FnOnce(&Iterate) -> T) -> T {
        let Self { problem, states, rest, .. } = self;
        let (u, load) = (states.last(), states.times[states.steps()]);
        let step = states.step(problem, rest, states.steps());
        look(&Iterate { step: Some(&step), ..problem.iterate(rest, &u, load) })
    }
}
