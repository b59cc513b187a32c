//! The steps of a run, one by one: through the time steps of a scene, to its full load, or along the path of its
//! equilibria.

use std::time::Instant;

use mechanics::energy::Iterate;
use mechanics::forward::{
    LoadStep, Problem, Progress, Reached, TimeStepper, Trajectory, Unreached, Workspace,
};
use mechanics::stability::{ArcProgress, Continuation};
use scene::Scene;

use crate::outlook::Outlook;
use crate::report::record::Finished;
use crate::report::{buckling, stability};

/// Memory for the states of a run; others lie on disk [B].
pub const STATE_MEMORY: f64 = 4e9;

/// A reported step as it was made.
pub struct Made {
    /// Its load steps; of one that was not reached those before the failure, of which none is reported.
    pub finished: Finished,
    /// Why the end of the step was not reached.
    pub unreached: Option<Unreached>,
}

/// Goes from one reported step of a run to the next: the ends of time steps, or the load steps of a static scene.
pub struct Steps<'a> {
    scene: &'a Scene,
    problem: &'a Problem,
    /// What goes from load step to load step.
    pub stepper: TimeStepper,
    /// What follows the path of a static scene by its arc length, if the scene asks for that.
    follower: Option<Continuation>,
    /// Ends of the time steps [s].
    times: Vec<f64>,
    /// Reported steps that were made.
    pub made: usize,
    /// Whether there is none to come.
    pub ended: bool,
    /// All states, if they are kept.
    pub states: Option<Trajectory>,
    /// Whether it was said that the body buckles.
    warned: bool,
    /// What the log says of every load step, if it does: when the run began, and how long it will take.
    progress: Option<(Instant, Outlook)>,
}

impl<'a> Steps<'a> {
    /// From rest to the end of the scene.
    pub fn new(scene: &'a Scene, problem: &'a Problem) -> Self {
        let integrator = scene.integrator(&scene.body, problem);
        Self {
            scene,
            problem,
            stepper: TimeStepper::new(scene.stepping(), integrator),
            follower: scene.path().map(Continuation::new),
            times: scene.times(),
            made: 0,
            ended: false,
            states: None,
            warned: false,
            progress: None,
        }
    }

    /// Not beyond the first time steps of the scene.
    pub fn up_to(mut self, time_steps: usize) -> Self {
        self.times.truncate(time_steps);
        self
    }

    /// After the reported steps that an interrupted run has made.
    pub fn after(mut self, made: usize, progress: Progress, path: Option<ArcProgress>) -> Self {
        self.stepper.progress = progress;
        self.follower.iter_mut().for_each(|follower| follower.progress.clone_from(&path));
        self.made = made;
        self.ended = self.in_time() && made >= self.times.len();
        self
    }

    /// With all states.
    pub fn keeping_states(mut self) -> Self {
        self.states = Some(Trajectory::begin(&self.stepper.progress.integrator, STATE_MEMORY));
        self
    }

    /// With a line in the log for every load step.
    pub fn with_progress(mut self, workspace: &mut Workspace) -> Self {
        let begin = self.share(self.made, self.stepper.iterate(self.problem, self.rest()).time);
        let largest = match self.in_time() {
            _ if self.follower.is_some() => 0.0,
            true => 1.0 / self.times.len() as f64,
            false => self.scene.config.solver.largest_load_step(),
        };
        self.progress =
            Some((Instant::now(), Outlook::new(self.in_time(), begin, largest, workspace)));
        self
    }

    /// Time that the whole run takes as was foreseen, if it was [s].
    pub fn foreseen(&self) -> Option<f64> {
        self.progress.as_ref()?.1.foreseen()
    }

    /// The share of the run that time steps are, or of a static scene a load.
    fn share(&self, made: usize, load: f64) -> f64 {
        if self.in_time() { made as f64 / self.times.len() as f64 } else { load }
    }

    fn in_time(&self) -> bool {
        self.scene.config.time.is_some()
    }

    fn rest(&self) -> &'a [mesh::Vec3] {
        &self.scene.body.mesh.vertices
    }

    /// Where the path is, if one is followed.
    pub fn path(&self) -> Option<&ArcProgress> {
        self.follower.as_ref()?.progress.as_ref()
    }

    /// Makes the next reported step; none at the end of the run.
    pub fn next(&mut self, workspace: &mut Workspace) -> Option<Made> {
        if self.ended {
            return None;
        }
        let made =
            if self.in_time() { self.time_step(workspace) } else { self.load_step(workspace) };
        self.ended |= made.unreached.is_some();
        Some(made)
    }

    fn time_step(&mut self, workspace: &mut Workspace) -> Made {
        let n = self.made;
        let prefix = format!("step {}/{}  ", n + 1, self.times.len());
        let mut steps: Vec<LoadStep> = Vec::new();
        let mut unreached = None;
        while unreached.is_none() && steps.last().is_none_or(|step| !step.ends_time_step) {
            match self.advance(workspace, self.times[n], &prefix) {
                Ok(step) => steps.push(step),
                Err(why) => unreached = Some(why),
            }
        }
        let integrator = &self.stepper.progress.integrator;
        if unreached.is_none() {
            self.made += 1;
            self.ended = self.made == self.times.len();
            self.states
                .iter_mut()
                .for_each(|all| all.push(self.times[n], integrator.last().clone()));
        }
        let velocity = integrator.method.has_inertia().then(|| integrator.last().v.clone());
        let reported = steps.len() - usize::from(unreached.is_none())..steps.len();
        Made { finished: Finished { steps, reported, velocity, checkpoint: None }, unreached }
    }

    fn load_step(&mut self, workspace: &mut Workspace) -> Made {
        let before = self.stepper.progress.last.last().cloned();
        let finished = |steps: Vec<LoadStep>| Finished {
            reported: 0..steps.len(),
            steps,
            velocity: None,
            checkpoint: None,
        };
        let step = match self.advance(workspace, 1.0, "") {
            Ok(step) => step,
            Err(why) => return Made { finished: finished(Vec::new()), unreached: Some(why) },
        };
        self.made += 1;
        self.warned = self.warned || self.warn_of_buckling(workspace, before, &step);
        let at = step.iterate(self.problem, self.rest());
        let cut = stability::ends_path(self.scene, self.made, &at, self.problem);
        self.ended = step.ends_time_step || cut.is_some();
        if let Some(why) = cut.filter(|_| !step.ends_time_step) {
            log::info!("the path ends at {} {why}", self.scene.progress(step.time));
        }
        if let (Some(states), true) = (&mut self.states, self.ended) {
            let rest = &self.scene.body.mesh.vertices;
            match step.ends_time_step {
                true => states.push(step.time, self.stepper.progress.integrator.last().clone()),
                false => states.push_displacement(self.problem, rest, step.time, &step.u),
            }
        }
        Made { finished: finished(vec![step]), unreached: None }
    }

    /// Warns where the body buckles near a load step that took many iterations; the state before it is none where it is the
    /// first.
    fn warn_of_buckling(
        &self,
        workspace: &mut Workspace,
        before: Option<Reached>,
        step: &LoadStep,
    ) -> bool {
        let (u, time) = before.map_or((vec![0.0; step.u.len()], 0.0), |b| (b.u, b.time));
        let at = Iterate { u: &u, time, ..step.iterate(self.problem, self.rest()) };
        let warning = buckling::foreseen(self.scene, (self.problem, workspace), &at, step);
        warning.iter().for_each(|warning| log::warn!("{warning}"));
        warning.is_some()
    }

    /// Says how far the run is, and how long it will take, if it says anything. Of a path the end is not foreseen.
    fn say(&mut self, prefix: &str, step: &LoadStep) {
        let share = self.share(self.made + usize::from(step.ends_time_step), step.time);
        let is_foreseen = self.follower.is_none() && (step.ends_time_step || !self.in_time());
        let Some((start, outlook)) = &mut self.progress else { return };
        let left = if is_foreseen { outlook.reached(share) } else { None };
        log::info!(
            "{prefix}{}  {:2} iterations, forces off balance by {:.1e} N  {:.1} s{}",
            self.scene.progress(step.time),
            step.newton_iterations,
            step.residual,
            start.elapsed().as_secs_f64(),
            left.map_or(String::new(), |left| format!(", {left}"))
        );
    }

    /// The next load step towards the end of a time step.
    fn advance(
        &mut self,
        workspace: &mut Workspace,
        end: f64,
        prefix: &str,
    ) -> Result<LoadStep, Unreached> {
        let (rest, stepper) = (&self.scene.body.mesh.vertices[..], &mut self.stepper);
        let step = match &mut self.follower {
            Some(follower) => follower.next(stepper, self.problem, workspace, rest)?,
            None => stepper.next(self.problem, workspace, rest, end)?,
        };
        self.say(prefix, &step);
        let ratio = step.smallest_volume_ratio;
        if ratio <= 0.0 {
            log::warn!(
                "an element is turned inside out, which is tolerated: volume ratio {ratio:.1e}"
            );
        }
        stability::in_words(&step).iter().for_each(|line| log::info!("{line}"));
        Ok(step)
    }
}
