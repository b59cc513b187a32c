//! Runs of scenes: the one door through which programs, studies and the Python package simulate.
//!
//! [`Run::new`] goes from rest through time, to the full load or along a path, or finds the equilibrium next to a known
//! one. A [`Run`] knows all its states, what is thought of them ([`Run::verdict`]), derivatives of its probes
//! ([`Run::sensitivities`]) and of anything else ([`Run::gradient`]), and writes its report ([`Run::write`]).
//!
//! Modules in dependency order; each uses only those before it:

pub mod report; // what is found of states and runs, in words, files and values
pub mod outlook; // how long they will take
pub mod steps; // one step after the other
pub mod next_to; // the equilibrium next to a known one
pub mod sensitivity; // derivatives of probes by numbers of a scene
pub mod limit; // how much more pressure a state bears
pub mod error_bars; // what probes change by if numbers are off
pub mod end; // what a run came to, in files

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result};
use measure::probe::Probe;
use mechanics::adjoint::{self, Gradient, NoGradient, Partials, Wanted};
use mechanics::element::FunctionSpace;
use mechanics::energy::Iterate;
use mechanics::forward::{
    Linearizations, LoadStep, Problem, State, Trajectory, Unreached, Watch, Workspace,
};
use program::FolderLock;
use scene::Scene;
use scene::config::SimConfig;

use crate::report::failure::Diagnosis;
use crate::report::record::{Finished, Recorder};
use crate::report::simulation::{self, Verdict};
use crate::report::{locking, results};
use end::Outcome;
use next_to::{is_free_of_history, next_to};
use steps::{Made, STATE_MEMORY, Steps};

/// A run that has come to its end.
pub struct Run {
    /// What was simulated.
    pub scene: Arc<Scene>,
    /// What was solved.
    pub problem: Problem,
    /// What is measured.
    pub probes: Vec<Probe>,
    /// The states at the ends of the time steps, of which a static scene has one.
    pub states: Trajectory,
    /// All load steps.
    pub load_steps: Vec<LoadStep>,
    /// All Newton iterations, those of rejected steps included.
    pub newton_iterations: usize,
    /// Wall time [s].
    pub seconds: f64,
    workspace: Mutex<Workspace>,
}

/// A run that did not come to its end.
pub struct NoEquilibrium {
    scene: Arc<Scene>,
    problem: Problem,
    workspace: Workspace,
    /// Where it came to, and what ended it.
    pub unreached: Unreached,
}

impl NoEquilibrium {
    /// Why there is no equilibrium, and what to do.
    pub fn in_words(mut self) -> String {
        let solver = (&self.problem, &mut self.workspace);
        Diagnosis::new(&self.scene, &self.scene.body, solver, &self.unreached).message
    }
}

/// How a run is made.
#[derive(Default)]
pub struct Start<'a> {
    /// A displacement [m] next to which the equilibrium is sought first, where the way there does not matter.
    pub near: Option<&'a [f64]>,
    /// What hears of its iterates, in place of the scene's own, which it is given.
    pub watch: Option<Box<dyn FnOnce(Option<Watch>) -> Watch + 'a>>,
}

impl Run {
    /// Simulates a scene.
    pub fn new(scene: impl Into<Arc<Scene>>, start: Start) -> Result<Result<Self, NoEquilibrium>> {
        let (scene, begin) = (scene.into(), Instant::now());
        let (problem, mut workspace) = scene.problem(&scene.body)?;
        let probes = scene.probes(&scene.body, &problem.space)?;
        if let Some(watch) = start.watch {
            workspace.watch = Some(watch(workspace.watch.take()));
        }
        let found = go(&scene, (&problem, &mut workspace), start.near);
        workspace.watch = None;
        let seconds = begin.elapsed().as_secs_f64();
        Ok(match found {
            Ok(found) => Ok(Self::made(scene, (problem, workspace, probes), found, seconds)),
            Err(unreached) => Err(NoEquilibrium { scene, problem, workspace, unreached }),
        })
    }

    /// A run as it was kept: all its load steps, and the states at the ends [s] of its time steps. It had taken some seconds.
    pub fn of_states(
        scene: Arc<Scene>,
        ends: impl IntoIterator<Item = (f64, State)>,
        mut load_steps: Vec<LoadStep>,
        (newton_iterations, seconds): (usize, f64),
    ) -> Result<Self> {
        let (problem, workspace) = scene.problem(&scene.body)?;
        let probes = scene.probes(&scene.body, &problem.space)?;
        let integrator = scene.integrator(&scene.body, &problem);
        let mut states = Trajectory::begin(&integrator, STATE_MEMORY);
        ends.into_iter().for_each(|(time, state)| states.push(time, state));
        let of_time_steps = load_steps.chunk_by_mut(|step, _| !step.ends_time_step);
        for (n, steps) in (1..).zip(of_time_steps) {
            let made = Arc::new(states.step(&problem, &scene.body.mesh.vertices, n));
            steps.iter_mut().for_each(|step| step.step = Some(Arc::clone(&made)));
        }
        let found = (states, load_steps, newton_iterations);
        Ok(Self::made(scene, (problem, workspace, probes), found, seconds))
    }

    fn made(
        scene: Arc<Scene>,
        (problem, workspace, probes): (Problem, Workspace, Vec<Probe>),
        (states, load_steps, newton_iterations): Found,
        seconds: f64,
    ) -> Self {
        let workspace = Mutex::new(workspace);
        Self { scene, problem, probes, states, load_steps, newton_iterations, seconds, workspace }
    }

    /// What derivatives are computed with; one computation after the other.
    pub fn workspace(&self) -> MutexGuard<'_, Workspace> {
        self.workspace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Rest positions of the vertices [m].
    pub fn rest(&self) -> &[mesh::Vec3] {
        &self.scene.body.mesh.vertices
    }

    /// The state at a load step.
    pub fn at<'a>(&'a self, step: &'a LoadStep) -> Iterate<'a> {
        step.iterate(&self.problem, self.rest())
    }

    /// The load steps of a static scene, the ends of the time steps of another.
    pub fn reported(&self) -> impl Iterator<Item = &LoadStep> {
        let is_static = self.scene.config.time.is_none();
        self.load_steps.iter().filter(move |step| is_static || step.ends_time_step)
    }

    /// The last load step.
    pub fn last(&self) -> Result<&LoadStep> {
        self.load_steps.last().context("the run has no steps")
    }

    /// Whether the end may be used, and why not. What a user should know of it is said in the log, as warnings.
    pub fn verdict(&self) -> Result<Verdict> {
        let last = self.last()?;
        let on_path = (self.load_steps.len(), Some(last));
        Ok(Verdict::new(&self.scene, &self.problem, &self.at(last), on_path, self.energy_gain()?))
    }

    /// Says what the elements hold back, where that is asked for or likely.
    pub fn estimate_locking(&self) {
        let on = (&self.problem, &self.probes[..]);
        let end = self.load_steps.last().map(|last| self.at(last));
        let _said = end.and_then(|end| locking::estimate(&self.scene, on, &end));
    }

    /// The value of each probe at the end of time step n ≥ 1, and its derivatives by all that the run depends on.
    pub fn sensitivities(&self, probes: &[&Probe], n: usize) -> Result<Vec<(f64, Gradient)>> {
        let solver = (&self.problem, &mut *self.workspace());
        sensitivity::sensitivities(&self.scene, solver, (probes, &self.states, n))
    }

    /// The derivatives of a result by all that the run depends on, from its partial derivatives at the end of each
    /// time step, which are added to `Partials`; what was linearised before is not linearised again.
    pub fn gradient(
        &self,
        known: &Linearizations,
        partials: impl FnMut(&FunctionSpace, usize, &mut Partials),
    ) -> Result<Gradient, NoGradient> {
        let on = (self.rest(), &self.states);
        adjoint::sweep(&self.problem, &mut self.workspace(), on, known, Wanted::All, partials)
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
        let mut report = simulation::begun(&scene, &self.problem, folder)?;
        // surfaces of obstacles lie beside the file that was read
        scene.path.clone_from(&self.scene.path);
        let on = (&self.problem, &self.probes[..]);
        let mut recorder = Recorder::new(&scene, on, folder, true, None)?;
        self.finished().try_for_each(|finished| recorder.write(finished))?;
        let (last, mut workspace) = (self.last()?, self.workspace());
        let velocity = self.velocity(self.states.steps());
        // the file that was written has it already
        report.set = self.scene.file.changes();
        simulation::follow(&mut report, &recorder, &workspace);
        let outcome = Outcome {
            end: self.at(last),
            last: Some(last),
            states: Some(&self.states),
            recorder: &recorder,
            newton_iterations: self.newton_iterations,
            velocity: velocity.as_deref(),
            equilibrium_s: self.seconds,
            predicted_s: None,
            since,
            before_s: self.seconds,
        };
        let solver = (&self.problem, &mut *workspace, &self.probes[..]);
        outcome.write(&scene, solver, folder, report).map(drop)
    }

    /// Largest energy that the steps in time have added, in parts of the largest that there is [1].
    fn energy_gain(&self) -> Result<Option<f64>> {
        if !self.states.method.has_inertia() {
            return Ok(None);
        }
        let mut recorder = Recorder::measuring(&self.scene, (&self.problem, &self.probes))?;
        self.finished().try_for_each(|finished| recorder.write(finished))?;
        Ok(recorder.largest_gain())
    }

    /// The load steps as they were made: those of a static scene one by one, those of a time step
    /// together, of which the last is reported.
    fn finished(&self) -> impl Iterator<Item = Finished> {
        let timed = self.scene.config.time.is_some();
        let groups = self.load_steps.chunk_by(move |step, _| timed && !step.ends_time_step);
        (1..).zip(groups).map(move |(n, group)| Finished {
            steps: group.to_vec(),
            reported: group.len() - 1..group.len(),
            velocity: if timed { self.velocity(n) } else { None },
            checkpoint: None,
        })
    }

    /// Velocity at the end of time step n, where there is inertia [m/s].
    fn velocity(&self, n: usize) -> Option<Vec<f64>> {
        self.states.method.has_inertia().then(|| self.states.state(n).into_owned().v)
    }
}

/// States at the ends of time steps, all load steps, and the number of Newton iterations.
type Found = (Trajectory, Vec<LoadStep>, usize);

/// Solves a scene: next to a displacement [m] if there is one and the way there does not matter; from rest where nothing
/// is found there.
fn go(
    scene: &Scene,
    (problem, workspace): (&Problem, &mut Workspace),
    near: Option<&[f64]>,
) -> Result<Found, Unreached> {
    let rest = &scene.body.mesh.vertices[..];
    let near = near.filter(|u| u.len() == problem.dofs() && is_free_of_history(scene));
    let (start, newton) = (scene.integrator(&scene.body, problem), scene.stepping().newton);
    let on = (rest, scene.end());
    let found = near.map(|u| next_to(&start, (problem, workspace), on, u, &newton));
    if let Some(Ok(step)) = found {
        let mut states = Trajectory::begin(&start, STATE_MEMORY);
        states.push_displacement(problem, rest, scene.end(), &step.u);
        let iterations = step.newton_iterations;
        return Ok((states, vec![LoadStep { ends_time_step: true, ..step }], iterations));
    }
    let mut steps = Steps::new(scene, problem).keeping_states();
    let mut load_steps = Vec::new();
    while let Some(Made { finished, unreached }) = steps.next(workspace) {
        if let Some(unreached) = unreached {
            return Err(steps.stepper.confirmed(problem, workspace, rest, &unreached));
        }
        load_steps.extend(finished.steps);
    }
    let iterations = steps.stepper.progress.newton_iterations;
    let states = steps.states.expect("they are kept");
    if let Some(error) = states.unwritten() {
        log::warn!("states could not be written ({error}); they stay in memory");
    }
    Ok((states, load_steps, iterations))
}
