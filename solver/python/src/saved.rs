//! A run as bytes, for `pickle`: its states, from which its problem is made again by its scene.

use std::sync::Arc;

use anyhow::{Context, Result};
use mechanics::forward::{LoadStep, Problem, State, Trajectory};
use serde::{Deserialize, Serialize};
use solver::study::course::{Course, STATE_MEMORY};

/// What is kept of a run beside its scene.
#[derive(Serialize, Deserialize)]
pub struct Saved {
    load_steps: Vec<LoadStep>,
    /// Ends of the time steps [s] ...
    times: Vec<f64>,
    /// ... and the states there.
    states: Vec<State>,
    newton_iterations: usize,
    /// Wall time [s].
    seconds: f64,
}

impl Saved {
    /// The states of a course that took some seconds.
    pub fn new(course: &Course, seconds: f64) -> Self {
        let Course { trajectory, load_steps, newton_iterations } = course;
        let state = |n| trajectory.state(n).into_owned();
        Self {
            load_steps: load_steps.clone(),
            times: trajectory.times[1..].to_vec(),
            states: (1..=trajectory.steps()).map(state).collect(),
            newton_iterations: *newton_iterations,
            seconds,
        }
    }

    /// As bytes.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        ciborium::into_writer(self, &mut bytes)?;
        Ok(bytes)
    }

    /// Of such bytes.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self> {
        ciborium::from_reader(bytes).context("no run of softpuffer")
    }

    /// The course of a scene with its problem, and the seconds that it took.
    pub fn course(self, scene: &scene::Scene, problem: &Problem) -> (Course, f64) {
        let rest = &scene.body.mesh.vertices[..];
        let integrator = scene.integrator(&scene.body, problem);
        let mut trajectory = Trajectory::begin(&integrator, STATE_MEMORY);
        for (time, state) in self.times.into_iter().zip(self.states) {
            trajectory.push(time, state);
        }
        let mut load_steps = self.load_steps;
        let of_time_steps = load_steps.chunk_by_mut(|step, _| !step.ends_time_step);
        for (n, steps) in (1..).zip(of_time_steps) {
            let made = Arc::new(trajectory.step(problem, rest, n));
            steps.iter_mut().for_each(|step| step.step = Some(Arc::clone(&made)));
        }
        let newton_iterations = self.newton_iterations;
        (Course { trajectory, load_steps, newton_iterations }, self.seconds)
    }
}
