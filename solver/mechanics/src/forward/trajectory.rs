//! The states at the ends of all time steps.

use std::borrow::Cow;

use mesh::Vec3;

use super::states::States;
use super::{Integrator, Method, Problem, State};
use crate::energy::{Iterate, TimeStep};

/// A run through time; a static scene is one time step from t = 0 to 1.
#[derive(Debug)]
pub struct Trajectory {
    /// The time integration.
    pub method: Method,
    /// t of each state [s], the first 0.
    pub times: Vec<f64>,
    /// The first that of t = 0.
    states: States,
}

impl Trajectory {
    /// The past before a step, with memory for the states [B]; others lie on disk.
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
        let step = integrator.step(self.times[self.steps()], time);
        let at = Iterate { step: Some(&step), ..problem.iterate(rest, u, time) };
        integrator.accept(&step, u, problem.energies.internal(&at));
        self.push(time, integrator.last().clone());
    }

    /// What the states leave of the memory for them [B].
    pub fn memory_left(&self) -> f64 {
        self.states.memory_left()
    }

    /// Why states beyond the budget could not be written to disk and are in memory, if any are.
    pub fn unwritten(&self) -> Option<&std::io::Error> {
        self.states.unwritten()
    }

    /// State n.
    pub fn state(&self, n: usize) -> Cow<'_, State> {
        self.states.get(n)
    }

    /// Displacements at the ends of the time steps [m].
    pub fn displacements(&self) -> impl Iterator<Item = Vec<f64>> {
        (1..=self.steps()).map(|n| self.state(n).into_owned().u)
    }

    /// Motion from one time to another [m], with states along lines in between; none where the
    /// run ends before.
    pub fn motion(&self, from: f64, to: f64) -> Option<Vec<f64>> {
        let (a, b) = (self.displacement(from)?, self.displacement(to)?);
        Some(b.iter().zip(&a).map(|(b, a)| b - a).collect())
    }

    fn displacement(&self, time: f64) -> Option<Vec<f64>> {
        let next = self.times.iter().position(|&t| t >= time)?;
        let after = self.state(next).into_owned().u;
        if self.times[next] == time {
            return Some(after);
        }
        let [start, end] = [next.checked_sub(1)?, next].map(|n| self.times[n]);
        let part = (time - start) / (end - start);
        let before = &self.state(next - 1).u;
        Some(before.iter().zip(after).map(|(a, b)| a + part * (b - a)).collect())
    }

    /// Number of time steps.
    pub fn steps(&self) -> usize {
        self.times.len() - 1
    }

    /// Displacement at the end [m].
    pub fn last(&self) -> Cow<'_, [f64]> {
        match self.state(self.steps()) {
            Cow::Borrowed(state) => Cow::Borrowed(&state.u),
            Cow::Owned(state) => Cow::Owned(state.u),
        }
    }

    /// What step n ≥ 1 looked back to, as when it was made.
    pub fn past(&self, n: usize) -> Integrator {
        let count = n.min(self.method.states());
        let states = (1..=count).map(|i| self.state(n - i).into_owned()).collect();
        Integrator { method: self.method, states }
    }

    /// Step n ≥ 1 with its lagged contacts.
    pub fn step(&self, problem: &Problem, rest: &[Vec3], n: usize) -> TimeStep {
        self.step_to(problem, rest, n, self.times[n])
    }

    /// The step from the last state to one at a time [s], with its lagged contacts.
    pub fn next_step(&self, problem: &Problem, rest: &[Vec3], end: f64) -> TimeStep {
        self.step_to(problem, rest, self.times.len(), end)
    }

    fn step_to(&self, problem: &Problem, rest: &[Vec3], n: usize, end: f64) -> TimeStep {
        let before = self.times[n - 1];
        let last = self.state(n - 1);
        let lagged_contacts = problem.lagged_contacts(&problem.iterate(rest, &last.u, before));
        TimeStep { lagged_contacts, ..self.past(n).step(before, end) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motion_between_states_goes_along_lines() {
        let state = |u: f64| State::new(vec![u, -u], vec![0.0; 2]);
        let mut run = Trajectory::begin(&Integrator::new(Method::Quasistatic, state(0.0)), 1e9);
        run.push(0.5, state(1.0));
        run.push(1.0, state(4.0));
        for (from, to, expected) in [(0.0, 0.5, 1.0), (0.5, 1.0, 3.0), (0.25, 0.75, 2.0)] {
            assert_eq!(run.motion(from, to), Some(vec![expected, -expected]), "{from} to {to}");
        }
        assert_eq!(run.motion(0.5, 1.5), None);
    }
}
