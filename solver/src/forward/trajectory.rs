//! The states at the ends of all time steps.

use std::borrow::Cow;

use mesh::Vec3;

use super::states::States;
use super::{Integrator, Method, Problem, State};
use crate::energy::{Iterate, TimeStep};

/// A run through time; a static scene is one time step from t = 0 to 1.
#[derive(Debug)]
pub struct Trajectory {
    /// Its time integration.
    pub method: Method,
    /// t of each state [s], the first 0.
    pub times: Vec<f64>,
    /// The first that of t = 0.
    states: States,
}

impl Trajectory {
    /// The past before a step, with memory for the states [B]; others lie on disk.
    #[must_use]
    pub fn begin(integrator: &Integrator, memory: f64) -> Self {
        let states = States::new(integrator.last().clone(), memory);
        Self { method: integrator.method, times: vec![0.0], states }
    }

    /// Adds the end of a time step.
    pub fn push(&mut self, time: f64, state: State) {
        self.times.push(time);
        self.states.push(state);
    }

    /// Adds the end of a time step by its displacement [m], on a rest shape [m].
    pub fn push_displacement(&mut self, problem: &Problem, rest: &[Vec3], time: f64, u: &[f64]) {
        let mut integrator = self.past(self.times.len());
        let step = integrator.step(time - self.times[self.steps()]);
        let at = Iterate { step: Some(&step), ..problem.iterate(rest, u, time) };
        integrator.accept(&step, u, problem.energies.relaxed(&at));
        self.push(time, integrator.last().clone());
    }

    /// State n.
    #[must_use]
    pub fn state(&self, n: usize) -> Cow<'_, State> {
        self.states.get(n)
    }

    /// Displacements at the ends of the time steps [m].
    pub fn displacements(&self) -> impl Iterator<Item = Vec<f64>> {
        (1..=self.steps()).map(|n| self.state(n).into_owned().u)
    }

    /// Motion during the time step that ends at a time [m], if there is one.
    #[must_use]
    pub fn motion_to(&self, end: f64) -> Option<Vec<f64>> {
        let n = self.times.iter().position(|&t| t == end).filter(|&n| n > 0)?;
        let (a, b) = (self.state(n - 1), self.state(n));
        Some(b.u.iter().zip(&a.u).map(|(b, a)| b - a).collect())
    }

    /// Number of time steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.times.len() - 1
    }

    /// Displacement at the end [m].
    #[must_use]
    pub fn last(&self) -> Cow<'_, [f64]> {
        match self.state(self.steps()) {
            Cow::Borrowed(state) => Cow::Borrowed(&state.u),
            Cow::Owned(state) => Cow::Owned(state.u),
        }
    }

    /// What step n ≥ 1 looked back to, as when it was made.
    #[must_use]
    pub fn past(&self, n: usize) -> Integrator {
        let count = n.min(self.method.order());
        let states = (1..=count).map(|i| self.state(n - i).into_owned()).collect();
        Integrator { method: self.method, states }
    }

    /// Step n ≥ 1 with its lagged contacts.
    #[must_use]
    pub fn step(&self, problem: &Problem, rest: &[Vec3], n: usize) -> TimeStep {
        let (before, end) = (self.times[n - 1], self.times[n]);
        let last = self.state(n - 1);
        let lagged_contacts = problem.lagged_contacts(&problem.iterate(rest, &last.u, before));
        TimeStep { lagged_contacts, ..self.past(n).step(end - before) }
    }
}
