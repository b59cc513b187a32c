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
