//! The exact Hessians at the ends of the time steps of a run, factored once for all that is asked of the run: its
//! gradient, its neighbours, and the starts of other runs next to it.

use std::collections::BTreeMap;

use mesh::Vec3;

use super::{Linearization, Problem, Trajectory, Workspace, solve_multipliers};
use crate::energy::Iterate;

/// Linearisations at the ends of time steps, as many of a run as are at hand.
#[derive(Clone, Debug, Default)]
pub struct Linearizations {
    steps: BTreeMap<usize, Linearization>,
}

impl Linearizations {
    /// One, at the end of time step n.
    pub fn at_step(n: usize, linearization: Linearization) -> Self {
        Self { steps: BTreeMap::from([(n, linearization)]) }
    }

    /// The last time step of a run on a rest shape [m], whose factor stays in the workspace until the next.
    pub fn at_end(
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        run: &Trajectory,
    ) -> Self {
        Self::at_step(run.steps(), linearize(problem, workspace, rest, run, run.steps()))
    }

    /// The time steps of a run on a rest shape [m], from the last one back, with their factors, while these take no more
    /// than `memory` [B].
    pub fn of(
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
        run: &Trajectory,
        memory: f64,
    ) -> Self {
        let one = workspace.memory_of_factor() as f64;
        let count = ((memory / one) as usize).min(run.steps());
        let mut step = |n: usize| {
            let linearization = linearize(problem, workspace, rest, run, n);
            (n, workspace.keep(linearization))
        };
        Self { steps: (run.steps() - count + 1..=run.steps()).rev().map(&mut step).collect() }
    }

    /// That at the end of time step n.
    pub fn step(&self, n: usize) -> Option<&Linearization> {
        self.steps.get(&n)
    }

    /// That at the end of a time step at a time [s].
    pub fn at_time(&self, time: f64) -> Option<&Linearization> {
        self.steps.values().find(|linearization| linearization.time() == time)
    }
}

/// Factors the exact Hessian at the end of time step n.
fn linearize(
    problem: &Problem,
    workspace: &mut Workspace,
    rest: &[Vec3],
    run: &Trajectory,
    n: usize,
) -> Linearization {
    let (state, step) = (run.state(n), run.step(problem, rest, n));
    let at = Iterate { step: Some(&step), ..problem.iterate(rest, &state.u, run.times[n]) };
    let multipliers = solve_multipliers(problem, workspace, &at);
    workspace.linearize(problem, &Iterate { multipliers: &multipliers, ..at })
}
