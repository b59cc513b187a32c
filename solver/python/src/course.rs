//! The states of a run: from rest, or next to a known equilibrium.

use mechanics::forward::{LoadStep, Problem, TimeStepper, Trajectory, Unreached, Workspace};
use solver::study::nearby::next_to;

/// Memory for states; others lie on disk [B].
const STATE_MEMORY: f64 = 4e9;

/// What was reached.
pub struct Course {
    pub trajectory: Trajectory,
    pub load_steps: Vec<LoadStep>,
    pub newton_iterations: usize,
}

impl Course {
    /// Solves a scene, next to a displacement [m] if there is one; from rest where nothing is found there.
    pub fn new(
        scene: &scene::Scene,
        problem: &Problem,
        workspace: &mut Workspace,
        start: Option<&[f64]>,
    ) -> Result<Self, Unreached> {
        let integrator = scene.integrator(&scene.body, problem);
        let rest = &scene.body.mesh.vertices[..];
        if let Some(Ok(step)) = start.map(|u| next_to(scene, (problem, workspace), u)) {
            let mut trajectory = Trajectory::begin(&integrator, STATE_MEMORY);
            trajectory.push_displacement(problem, rest, step.time, &step.u);
            let newton_iterations = step.newton_iterations;
            return Ok(Self { trajectory, load_steps: vec![step], newton_iterations });
        }
        let mut stepper = TimeStepper::new(scene.stepping(), integrator);
        let mut load_steps = Vec::new();
        let keep = |step: &LoadStep| load_steps.push(step.clone());
        let trajectory =
            stepper.run(problem, workspace, rest, &scene.times(), STATE_MEMORY, keep)?;
        let newton_iterations = stepper.progress.newton_iterations;
        Ok(Self { trajectory, load_steps, newton_iterations })
    }
}
