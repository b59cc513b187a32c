//! The states at the ends of all time steps.

use mesh::Vec3;

use super::{Integrator, Method, State, System};
use crate::energy::TimeStep;

/// A run through time; a static scene is one time step from t = 0 to 1.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// How it went from state to state.
    pub method: Method,
    /// t of each state [s], the first 0.
    pub times: Vec<f64>,
    /// The states, the first that of t = 0.
    pub states: Vec<State>,
}

impl Trajectory {
    /// The past before a step.
    #[must_use]
    pub fn begin(integrator: &Integrator) -> Self {
        let (method, states) = (integrator.method, vec![integrator.last().clone()]);
        Self { method, times: vec![0.0], states }
    }

    /// Adds the end of a time step.
    pub fn push(&mut self, time: f64, state: State) {
        self.times.push(time);
        self.states.push(state);
    }

    /// The run from a start through displacements [m] at the ends of time steps [s].
    #[must_use]
    pub fn through(start: &Integrator, ends: &[f64], displacements: &[Vec<f64>]) -> Self {
        let (mut run, mut integrator) = (Self::begin(start), start.clone());
        for (&end, u) in ends.iter().zip(displacements) {
            let step = integrator.step(end - run.times[run.steps()]);
            integrator.accept(&step, u);
            run.push(end, integrator.last().clone());
        }
        run
    }

    /// Motion during the time step that ends at a time [m], if there is one.
    #[must_use]
    pub fn motion_to(&self, end: f64) -> Option<Vec<f64>> {
        let n = self.times.iter().position(|&t| t == end).filter(|&n| n > 0)?;
        let (a, b) = (&self.states[n - 1].u, &self.states[n].u);
        Some(b.iter().zip(a).map(|(b, a)| b - a).collect())
    }

    /// Number of time steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.times.len() - 1
    }

    /// Displacement at the end [m].
    #[must_use]
    pub fn last(&self) -> &[f64] {
        &self.states[self.steps()].u
    }

    /// What step n ≥ 1 looked back to, as when it was made.
    #[must_use]
    pub fn past(&self, n: usize) -> Integrator {
        let count = n.min(self.method.order());
        let states = (1..=count).map(|i| self.states[n - i].clone()).collect();
        Integrator { method: self.method, states }
    }

    /// Step n ≥ 1 with the contacts that rub in it.
    #[must_use]
    pub fn step(&self, system: &System, rest: &[Vec3], n: usize) -> TimeStep {
        let (before, end) = (self.times[n - 1], self.times[n]);
        let sliding = system.sliding(rest, &self.states[n - 1].u, before);
        TimeStep { sliding, ..self.past(n).step(end - before) }
    }
}
