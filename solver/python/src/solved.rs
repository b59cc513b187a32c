//! A run of a scene, without Python.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result};
use measure::probe::Probe;
use mechanics::energy::Iterate;
use mechanics::forward::{LoadStep, Problem, Watch, Workspace, predicted_time};
use program::FolderLock;
use reports::Status;
use scene::config::SimConfig;
use solver::report::failure::Diagnosis;
use solver::report::locking;
use solver::report::record::{Finished, Recorder};
use solver::report::results;
use solver::report::simulation::{self, Spent, Verdict};
use solver::study::course::Course;
use solver::study::outcome::Outcome;

use crate::saved::Saved;

/// A run that has come to its end.
pub struct Solved {
    pub scene: Arc<scene::Scene>,
    pub problem: Problem,
    pub workspace: Mutex<Workspace>,
    pub probes: Vec<Probe>,
    pub course: Course,
    /// Wall time [s].
    seconds: f64,
    /// What the result is.
    pub status: Status,
    /// Why it must not be used, if it must not.
    pub refusal: Option<String>,
}

impl Solved {
    /// The run, or why there is no equilibrium.
    pub fn solve(
        scene: Arc<scene::Scene>,
        start: Option<&[f64]>,
        watch: impl FnOnce(Option<Watch>) -> Watch,
    ) -> Result<Result<Self, String>> {
        let begin = Instant::now();
        let (problem, mut workspace) = scene.problem(&scene.body)?;
        let probes = scene.probes(&scene.body, &problem.space)?;
        scene.check_loads()?;
        simulation::foresee(&scene);
        workspace.watch = Some(watch(workspace.watch.take()));
        let course = Course::new(&scene, (&problem, &mut workspace), start);
        workspace.watch = None;
        match course {
            Ok(course) => {
                let solver = (problem, workspace, probes);
                Self::judged(scene, solver, course, begin.elapsed().as_secs_f64()).map(Ok)
            }
            Err(unreached) => {
                let solver = (&problem, &mut workspace);
                Ok(Err(Diagnosis::new(&scene, &scene.body, solver, &unreached).message))
            }
        }
    }

    /// A run of a scene, as it was kept.
    pub fn of_saved(scene: Arc<scene::Scene>, saved: Saved) -> Result<Self> {
        let (problem, workspace) = scene.problem(&scene.body)?;
        let probes = scene.probes(&scene.body, &problem.space)?;
        let (course, seconds) = saved.course(&scene, &problem);
        Self::judged(scene, (problem, workspace, probes), course, seconds)
    }

    /// What is to be kept of it.
    pub fn to_saved(&self) -> Saved {
        Saved::new(&self.course, self.seconds)
    }

    /// The run with what is to be thought of it.
    fn judged(
        scene: Arc<scene::Scene>,
        (problem, workspace, probes): (Problem, Workspace, Vec<Probe>),
        course: Course,
        seconds: f64,
    ) -> Result<Self> {
        let mut run = Self {
            scene,
            problem,
            workspace: Mutex::new(workspace),
            probes,
            course,
            seconds,
            status: Status::Ok,
            refusal: None,
        };
        let verdict = {
            let last = run.course.load_steps.last().context("the run has no steps")?;
            let on_path = (run.course.load_steps.len(), Some(last));
            Verdict::new(&run.scene, &run.problem, &run.at(last), on_path, run.gain()?)
        };
        (run.status, run.refusal) = (verdict.status(), verdict.refusal());
        Ok(run)
    }

    /// Largest energy that the steps in time have added, in parts of the largest that there is [1].
    fn gain(&self) -> Result<Option<f64>> {
        if !self.course.trajectory.method.has_inertia() {
            return Ok(None);
        }
        let mut recorder = Recorder::measuring(&self.scene, (&self.problem, &self.probes))?;
        self.finished().try_for_each(|finished| recorder.write(finished))?;
        Ok(recorder.largest_gain())
    }

    /// Says what the elements hold back, where it is asked for or likely.
    pub fn estimate_locking(&self) {
        let on = (&self.problem, &self.probes[..]);
        let end = self.course.load_steps.last().map(|last| self.at(last));
        let _said = end.and_then(|end| locking::estimate(&self.scene, on, &end));
    }

    /// Writes what `solver simulate` writes, of a scene that lies in a file with its meshes.
    pub fn write(&self, folder: &Path, path: &Path, meshes: Vec<PathBuf>) -> Result<()> {
        let since = Instant::now();
        let mut scene = (*self.scene).clone();
        scene.file = SimConfig::settings(path, &[])?;
        scene.path = path.to_owned();
        let names = meshes.iter().filter_map(|mesh| mesh.file_name().map(PathBuf::from));
        scene.config.set_meshes(names.collect())?;
        scene.parts.iter_mut().zip(meshes).for_each(|(part, mesh)| part.mesh_path = mesh);
        let _lock = FolderLock::new(folder)?;
        results::remove_stale(folder, 0)?;
        let on = (&self.problem, &self.probes[..]);
        let mut recorder = Recorder::new(&scene, on, folder, true, None)?;
        self.finished().try_for_each(|finished| recorder.write(finished))?;
        let Course { trajectory, load_steps, newton_iterations } = &self.course;
        let last = load_steps.last().context("the run has no steps")?;
        let mut workspace = self.workspace.lock().unwrap_or_else(PoisonError::into_inner);
        let (timings, velocity) = (workspace.timings, self.velocity(trajectory.steps()));
        let steps = scene.config.steps(scene.times().len());
        let spent = Spent {
            newton_iterations: *newton_iterations,
            velocity: velocity.as_deref(),
            recorder: &recorder,
            timings: &timings,
            equilibrium_s: self.seconds,
            predicted_s: predicted_time(&self.problem, &workspace, steps),
        };
        let mut report = simulation::begun(&scene, &self.problem, folder)?;
        simulation::follow(&mut report, &recorder, &workspace);
        let (end, states, before_s) = (self.at(last), Some(trajectory), self.seconds);
        let outcome = Outcome { end, last: Some(last), states, spent, since, before_s };
        let solver = (&self.problem, &mut *workspace, &self.probes[..]);
        outcome.write(&scene, solver, folder, report).map(drop)
    }

    /// The load steps as they were made: those of a static scene one by one, those of a time step
    /// together, of which the last is reported.
    fn finished(&self) -> impl Iterator<Item = Finished> {
        let timed = self.scene.config.time.is_some();
        let groups = self.course.load_steps.chunk_by(move |step, _| timed && !step.ends_time_step);
        (1..).zip(groups).map(move |(n, group)| Finished {
            steps: group.to_vec(),
            reported: group.len() - 1..group.len(),
            velocity: if timed { self.velocity(n) } else { None },
            checkpoint: None,
        })
    }

    /// Velocity at the end of time step n, where there is inertia [m/s].
    fn velocity(&self, n: usize) -> Option<Vec<f64>> {
        let trajectory = &self.course.trajectory;
        trajectory.method.has_inertia().then(|| trajectory.state(n).into_owned().v)
    }

    /// Whether a step is reported.
    fn reports(&self, step: &LoadStep) -> bool {
        step.ends_time_step || self.scene.config.time.is_none()
    }

    /// The load steps of a static scene, the ends of the time steps of another.
    pub fn steps(&self) -> impl Iterator<Item = &LoadStep> {
        self.course.load_steps.iter().filter(|step| self.reports(step))
    }

    /// The state at a step.
    pub fn at<'a>(&'a self, step: &'a LoadStep) -> Iterate<'a> {
        step.iterate(&self.problem, &self.scene.body.mesh.vertices)
    }
}
