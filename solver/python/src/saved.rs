//! A run as bytes, for `pickle`: its states, from which its problem is made again by its scene.

use std::sync::Arc;

use anyhow::{Context, Result};
use mechanics::forward::{LoadStep, State};
use run::Run;
use serde::{Deserialize, Serialize};

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
    /// What is to be kept of a run.
    pub fn new(run: &Run) -> Self {
        Self {
            load_steps: run.load_steps.clone(),
            times: run.states.times[1..].to_vec(),
            states: (1..=run.states.steps()).map(|n| run.states.state(n).into_owned()).collect(),
            newton_iterations: run.newton_iterations,
            seconds: run.seconds,
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

    /// The run of a scene.
    pub fn run(self, scene: Arc<scene::Scene>) -> Result<Run> {
        let ends = self.times.into_iter().zip(self.states);
        Run::of_states(scene, ends, self.load_steps, (self.newton_iterations, self.seconds))
    }
}
