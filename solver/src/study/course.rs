//! The states of a run: from rest through time, to the full load or along a path, or next to a known equilibrium.

use mechanics::forward::{LoadStep, Problem, TimeStepper, Trajectory, Unreached, Workspace};
use mechanics::stability::Continuation;
use scene::Scene;

use super::nearby::{is_free_of_history, next_to};
use crate::report::leap::leap;
use crate::report::simulation::judge_step;
use crate::report::stability;

/// Memory for states; others lie on disk [B].
pub const STATE_MEMORY: f64 = 4e9;

/// What was reached.
pub struct Course {
    /// The states at the ends of the time steps, of which a static scene has one.
    pub trajectory: Trajectory,
    /// All load steps.
    pub load_steps: Vec<LoadStep>,
    /// All Newton iterations, those of rejected steps included.
    pub newton_iterations: usize,
}

impl Course {
    /// Solves a scene: next to a displacement [m] if there is one and the way there does not matter; from rest where
    /// nothing is found there.
    pub fn new(
        scene: &Scene,
        (problem, workspace): (&Problem, &mut Workspace),
        start: Option<&[f64]>,
    ) -> Result<Self, Unreached> {
        let integrator = scene.integrator(&scene.body, problem);
        let rest = &scene.body.mesh.vertices[..];
        let start = start.filter(|u| u.len() == problem.dofs() && is_free_of_history(scene));
        if let Some(Ok(step)) = start.map(|u| next_to(scene, (problem, workspace), u)) {
            let mut trajectory = Trajectory::begin(&integrator, STATE_MEMORY);
            trajectory.push_displacement(problem, rest, step.time, &step.u);
            let newton_iterations = step.newton_iterations;
            return Ok(Self { trajectory, load_steps: vec![step], newton_iterations });
        }
        let mut stepper = TimeStepper::new(scene.stepping(), integrator);
        let way = if scene.path().is_some() { follow } else { go };
        match way(scene, (problem, &mut *workspace), &mut stepper) {
            Ok((trajectory, load_steps)) => {
                let newton_iterations = stepper.progress.newton_iterations;
                Ok(Self { trajectory, load_steps, newton_iterations })
            }
            Err(unreached) => Err(stepper.confirmed(problem, workspace, rest, &unreached)),
        }
    }
}

/// States at the ends of time steps, and all load steps.
type Reached = Result<(Trajectory, Vec<LoadStep>), Unreached>;

/// Goes through the time steps of a scene.
fn go(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    stepper: &mut TimeStepper,
) -> Reached {
    let (rest, mut load_steps) = (&scene.body.mesh.vertices[..], Vec::new());
    let timed = scene.config.time.is_some();
    let (mut before, mut leapt) = (vec![0.0; problem.dofs()], false);
    let keep = |step: &LoadStep| {
        judge_step(step);
        if timed && step.ends_time_step && !leapt {
            let leap = leap(&scene.body, &before, &step.u);
            leapt = leap.is_some();
            leap.iter().for_each(|leap| log::warn!("t = {:.4e} s: {leap}", step.time));
            before.clone_from(&step.u);
        }
        load_steps.push(step.clone());
    };
    let run = stepper.run(problem, workspace, rest, &scene.times(), STATE_MEMORY, keep)?;
    Ok((run, load_steps))
}

/// Follows the path of a static scene to its end.
fn follow(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    stepper: &mut TimeStepper,
) -> Reached {
    let (rest, mut load_steps) = (&scene.body.mesh.vertices[..], Vec::new());
    let mut trajectory = Trajectory::begin(&stepper.progress.integrator, STATE_MEMORY);
    let mut follower = scene.path().map(Continuation::new);
    while let Some(on_path) = &mut follower {
        let step = on_path.next(stepper, problem, workspace, rest)?;
        judge_step(&step);
        let made = load_steps.len() + 1;
        let cut = stability::ends_path(scene, made, &step.iterate(problem, rest), problem);
        if step.ends_time_step || cut.is_some() {
            trajectory.push_displacement(problem, rest, step.time, &step.u);
            follower = None;
        }
        load_steps.push(step);
    }
    Ok((trajectory, load_steps))
}
