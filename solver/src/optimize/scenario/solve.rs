//! Runs of a scenario: from rest, next to another run, or the one equilibrium next to a displacement.

use std::sync::Arc;

use mechanics::energy::Iterate;
use mechanics::forward::{
    Configuration, Failure, Newton, Problem, Stepping, TimeStepper, Trajectory, solve_from,
    solve_multipliers,
};
use mesh::Vec3;
use program::Heartbeat;

use super::{Rejected, Scenario};
use crate::report::failure::inverted;

/// Newton iterations from a nearby equilibrium. Accepted shapes of the frog
/// took 2 to 8; what takes more is better reached by a shorter step.
const NEARBY: usize = 12;
/// Newton iterations in a load step of a run next to another, where bodies hit each other:
/// simulated from rest, the worm took at most 22, the gripper 11.
const NEARBY_IN_TIME: usize = 30;
/// Smallest load step of such a run, as a fraction of a time step.
const NEARBY_INCREMENT: f64 = 0.25;

/// Volume at which a softening chamber is taken to balloon, over that at its start: next to another run ...
const BALLOONED_NEARBY: f64 = 1.0;
/// ... and from rest, where a chamber may grow a lot.
const BALLOONED: f64 = 4.0;

impl Scenario {
    /// How a run from rest steps, or one next to a run on another mesh.
    pub(super) fn patient(&self) -> Stepping {
        let newton = Newton { ballooned: Some(BALLOONED), ..self.stepping.newton };
        Stepping { newton, ..self.stepping }
    }

    /// How a run next to another one steps: what needs more is not near.
    pub(super) fn nearby(&self) -> Stepping {
        let mut stepping = self.stepping;
        stepping.newton.iterations = stepping.newton.iterations.min(NEARBY_IN_TIME);
        stepping.newton.ballooned = Some(BALLOONED_NEARBY);
        stepping.smallest = stepping.smallest.max(NEARBY_INCREMENT);
        stepping
    }

    /// All states from rest.
    pub(super) fn solve(
        &mut self,
        problem: &Arc<Problem>,
        rest: &[Vec3],
        guide: Option<Arc<Trajectory>>,
        stepping: Stepping,
    ) -> Result<(Trajectory, usize), Rejected> {
        let near = self.linearized.as_ref().filter(|_| guide.is_some());
        let factors = near.map(|(_, known)| Arc::clone(known)).unwrap_or_default();
        let stepper = TimeStepper::new(stepping, self.start.clone());
        let mut stepper = stepper.guided(guide).with_factors(factors);
        let mut heartbeat = Heartbeat::start();
        let (scene, workspace, times) = (&self.scene, &mut self.workspace, &self.times);
        let title = self.config.title().map(|title| format!("{title}: ")).unwrap_or_default();
        let run = stepper.run(problem, workspace, rest, times, self.state_memory, |step| {
            heartbeat.say(|| format!("  {title}a run is at {}", scene.progress(step.time)));
        });
        match run {
            Ok(states) => Ok((states, stepper.progress.newton_iterations)),
            Err(unreached) => {
                let rejected = self.reject(&unreached);
                self.unreached = Some((Arc::clone(problem), unreached));
                Err(rejected)
            }
        }
    }

    /// The one equilibrium next to a displacement.
    pub(super) fn solve_next_to(
        &mut self,
        problem: &Problem,
        rest: &[Vec3],
        u: &[f64],
    ) -> Result<(Trajectory, usize), Rejected> {
        let time = self.times[0];
        let step = Arc::new(self.one_step(problem, rest, u).step(problem, rest, 1));
        let at = Iterate { step: Some(&step), ..problem.iterate(rest, u, time) };
        let multipliers = solve_multipliers(problem, &mut self.workspace, &at);
        let start = Configuration { rest, time, step: Some(&step), u: u.to_vec(), multipliers };
        let newton = Newton {
            iterations: NEARBY,
            ballooned: Some(BALLOONED_NEARBY),
            ..self.stepping.newton
        };
        let solution =
            solve_from(problem, &mut self.workspace, &start, &newton).map_err(|failure| {
                match inverted(&problem.space, rest, u) {
                    Some(said) if matches!(failure, Failure::Inadmissible) => {
                        self.reject(format!("foreseen from the step before, {said}"))
                    }
                    _ => self.reject(failure),
                }
            })?;
        Ok((self.one_step(problem, rest, &solution.u), solution.newton_iterations))
    }

    /// The run to a displacement in one step.
    fn one_step(&self, problem: &Problem, rest: &[Vec3], u: &[f64]) -> Trajectory {
        let mut run = Trajectory::begin(&self.start, self.state_memory);
        run.push_displacement(problem, rest, self.times[0], u);
        run
    }
}
