//! `solver simulate`: a scene to its equilibrium, or through time, and a report.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::builder::RangedU64ValueParser;
use measure::probe::Probe;
use mechanics::energy::Iterate;
use mechanics::forward::{
    ArcFollower, LoadStep, Problem, Reached, Steps, TimeStepper, Trajectory, Unreached, Workspace,
    about, predicted_iterations, predicted_time,
};
use program::{Changes, FolderLock, Unusable};
use reports::{AsCast, Simulation};
use scene::{Scene, log_share};

use crate::report::buckling;
use crate::report::failure::Diagnosis;
use crate::report::leap::leap;
use crate::report::meeting;
use crate::report::record::{Checkpoint, Finished, Recorder, Work};
use crate::report::results;
use crate::report::simulation::{self, Spent};
use crate::report::stability;
use crate::report::time_left::{Pace, foretell};
use crate::report::writer::{Writer, write_beside};
use crate::study::as_cast;
use crate::study::outcome::Outcome;
use crate::study::uncertainty;

/// Solve a scene for its equilibrium under the full load, or through time
///
/// Writes to the output folder: report.json, nodes.npy and displacement.npy
/// (exact, of the last state), result.pvd with one .vtu per load step or, in a
/// scene with [time], per time step, steps.jsonl with one line for each, curve.csv with a row, and
/// result.vtu. A run that was interrupted continues after its last step when the same
/// command is given again.
#[derive(clap::Args)]
pub struct Arguments {
    /// The scene
    scene: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Another tagged mesh in place of the scene's
    #[arg(long, value_parser = super::other_mesh)]
    mesh: Vec<super::OtherMesh>,
    /// What was measured of the cast body (TOML): walls are moved to it before the run
    #[arg(long, value_name = "MEASURED")]
    as_cast: Option<PathBuf>,
    /// Another degree of the displacement in place of the scene's: 1, 2 or 3
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(1..=3))]
    degree: Option<usize>,
    /// Only the first of the scene's time steps
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    steps: Option<usize>,
    /// Ten load steps, the points of a curve, where the scene gives no largest_load_step
    #[arg(long)]
    curve: bool,
    /// Only the final state, no file per step
    #[arg(long)]
    final_only: bool,
    /// Do not prove that no surfaces intersect: of every step with contact, of the last without
    #[arg(long)]
    no_certify: bool,
    /// Forget an interrupted run in the folder
    #[arg(long)]
    restart: bool,
    #[command(flatten)]
    changes: Changes,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let (scene, as_cast) = read(arguments)?;
    let begin = Instant::now();
    let (problem, mut workspace) = scene.problem(&scene.body)?;
    let probes = scene.probes(&scene.body, &problem.space)?;
    scene.check_loads()?;
    uncertainty::check(&scene)?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    let inputs = hash_inputs(&scene, arguments.as_cast.as_deref())?;
    let checkpoint = if arguments.restart { None } else { Checkpoint::read(folder, &inputs)? };
    let done = checkpoint.as_ref().map_or(0, |c| c.steps);
    results::remove_stale(folder, done)?;
    announce(&scene, &workspace);
    if done == 0 {
        meeting::foresee(&scene, &problem, &mut workspace);
    }
    let timed = scene.config.time.is_some();
    let time_steps_done = if timed { done } else { 0 };
    let steps = steps_of(&scene, arguments, time_steps_done);
    let kind = scene.config.steps(steps.len());
    let predicted_s = predicted_time(&problem, &workspace, kind);
    // steps tell how long the rest takes, and the end of a path is not known
    if matches!(kind, Steps::Load(1)) && scene.path().is_none() {
        let expected = predicted_iterations(&problem, kind);
        workspace.watch = Some(foretell(workspace.watch.take(), expected));
    }
    log::info!("about {} on {} threads", about(predicted_s), rayon::current_num_threads());
    let before_s = checkpoint.as_ref().map_or(0.0, |c| c.elapsed_s);
    let pictures = !arguments.final_only;
    let mut recorder =
        Recorder::new(&scene, (&problem, &probes), folder, pictures, checkpoint.as_ref())?;
    let mut run = Run::new(&scene, (&problem, workspace, &probes), checkpoint);
    let mut report = simulation::begun(&scene, &problem, folder)?;
    report.as_cast = as_cast;
    let checkpoint = |run: &Run, steps: usize| Checkpoint {
        inputs: inputs.clone(),
        steps,
        lines: String::new(),
        pictures: BTreeMap::new(),
        progress: run.stepper.progress.clone(),
        path: run.follower.as_ref().and_then(|follower| follower.progress.clone()),
        couplings: run.workspace.couplings().to_vec(),
        work: Work::default(),
        timings: run.workspace.timings,
        elapsed_s: before_s + begin.elapsed().as_secs_f64(),
    };
    let (outcome, waited) =
        write_beside(&mut recorder, |writer| run.go(steps, writer, checkpoint))?;
    run.workspace.timings.output += waited;
    let equilibrium_s = before_s + begin.elapsed().as_secs_f64();
    simulation::follow(&mut report, &recorder, &run.workspace);
    Checkpoint::remove(folder)?;
    if let Some(unreached) = outcome {
        return Err(run.failed(report, arguments, &unreached)?);
    }
    let spent = [equilibrium_s, predicted_s];
    let refusal = run.end(report, folder, &recorder, (start, before_s, spent))?;
    let Some(refusal) = refusal else { return Ok(()) };
    Err(Unusable(format!("{}: {refusal}", arguments.scene.display())).into())
}

/// The scene with what the arguments change, and its walls as they were measured.
fn read(arguments: &Arguments) -> Result<(Scene, Option<AsCast>)> {
    let mut scene = Scene::read_with(&arguments.scene, &arguments.mesh, &arguments.changes.set)?;
    scene.config.degree = arguments.degree.unwrap_or(scene.config.degree);
    scene.certify = !arguments.no_certify;
    if arguments.curve {
        scene.config.solver.step_for_curves();
    }
    let as_cast = arguments.as_cast.as_ref().map(|path| as_cast::apply(&mut scene, path));
    let as_cast = as_cast.transpose()?;
    as_cast.iter().flat_map(as_cast::in_words).for_each(|line| log::info!("{line}"));
    Ok((scene, as_cast))
}

/// Says what will be solved.
fn announce(scene: &Scene, workspace: &Workspace) {
    let silicones = scene.laws.iter().filter_map(|law| law.config.silicone());
    for line in silicones.map(|named| named.in_words()).collect::<BTreeSet<_>>() {
        log::info!("{line}");
    }
    simulation::foresee(scene);
    scene.membranes.iter().for_each(|membrane| log::info!("{}", membrane.in_words()));
    scene.config.fibre.iter().for_each(|fibre| log::info!("{}", fibre.in_words()));
    scene.config.winding.iter().for_each(|winding| log::info!("{}", winding.in_words()));
    scene.config.relaxation.iter().for_each(|branch| log::info!("{}", branch.in_words()));
    scene.config.mullins.iter().for_each(|softening| log::info!("{}", softening.in_words()));
    log::info!(
        "{} tets, degree {}, {}",
        scene.body.mesh.tets.len(),
        scene.config.degree,
        workspace.memory().describe(system::available_memory())
    );
    log_share(&scene.body);
}

/// Memory for all states, where error bars need them; others lie on disk [B].
const STATE_MEMORY: f64 = 4e9;

/// Least time between two checkpoints of a static run.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(1);

/// A run of a scene.
struct Run<'a> {
    scene: &'a Scene,
    problem: &'a Problem,
    probes: &'a [Probe],
    workspace: Workspace,
    stepper: TimeStepper,
    /// What follows the path of a static scene by its arc length, if the scene asks for that.
    follower: Option<ArcFollower>,
    /// The last state of that path.
    last: Option<LoadStep>,
    /// All states, where error bars need them.
    states: Option<Trajectory>,
    /// Load steps of a static scene that an interrupted run has made.
    done: usize,
    start: Instant,
    pace: Pace,
}

impl<'a> Run<'a> {
    /// Begins at rest, or where an interrupted run was.
    fn new(
        scene: &'a Scene,
        (problem, mut workspace, probes): (&'a Problem, Workspace, &'a [Probe]),
        checkpoint: Option<Checkpoint>,
    ) -> Self {
        let integrator = scene.integrator(&scene.body, problem);
        let mut stepper = TimeStepper::new(scene.stepping(), integrator);
        let mut follower = scene.path().map(ArcFollower::new);
        let done = checkpoint.as_ref().map_or(0, |c| c.steps);
        let timed = scene.config.time.is_some();
        if let Some(checkpoint) = checkpoint {
            follower.iter_mut().for_each(|f| f.progress.clone_from(&checkpoint.path));
            let steps = if timed { "time steps" } else { "load steps" };
            log::info!("continuing after {} {steps}", checkpoint.steps);
            workspace.set_couplings(problem, checkpoint.couplings);
            workspace.timings = checkpoint.timings;
            stepper.progress = checkpoint.progress;
        }
        let states = all_states(scene, &stepper, if timed { done } else { 0 });
        let (last, start) = (None, Instant::now());
        let reached = stepper.progress.last.last();
        let from = reached.map_or(stepper.progress.time, |last| last.time);
        let pace = Pace::new(from, scene.end());
        Self {
            scene,
            problem,
            probes,
            workspace,
            stepper,
            follower,
            last,
            states,
            done,
            start,
            pace,
        }
    }

    /// Goes through some of the scene's time steps; the result says where that ends early.
    fn go(
        &mut self,
        time_steps: Range<usize>,
        writer: &mut Writer,
        checkpoint: impl Fn(&Self, usize) -> Checkpoint,
    ) -> Result<Option<Unreached>> {
        if self.scene.config.time.is_none() {
            return self.go_to_load(writer, checkpoint);
        }
        let count = time_steps.end;
        if let Some(n) = time_steps.clone().last() {
            self.pace.end = self.scene.times()[n];
        }
        let mut leapt = false;
        for n in time_steps {
            let before = self.stepper.progress.reached().to_vec();
            let mut steps: Vec<LoadStep> = Vec::new();
            let end = self.scene.times()[n];
            let outcome = loop {
                match self.next(end, &format!("step {}/{count}  ", n + 1)) {
                    Ok(step) => steps.push(step),
                    Err(unreached) => break Err(unreached),
                }
                if steps.last().is_some_and(|step| step.ends_time_step) {
                    break Ok(());
                }
            };
            let leap = leap(&self.scene.body, &before, self.stepper.progress.reached());
            if let Some(leap) = leap.filter(|_| !leapt) {
                log::warn!("{}: time step {}: {leap}", self.scene.path.display(), n + 1);
                leapt = true;
            }
            let reported = steps.len() - usize::from(outcome.is_ok())..steps.len();
            let integrator = &self.stepper.progress.integrator;
            let velocity = integrator.method.has_inertia().then(|| integrator.last().v.clone());
            let goes_on = outcome.is_ok() && n + 1 < count;
            let checkpoint = goes_on.then(|| checkpoint(self, n + 1));
            writer.send(Finished { steps, reported, velocity, checkpoint })?;
            if let Err(unreached) = outcome {
                return Ok(Some(unreached));
            }
        }
        Ok(None)
    }

    /// Goes through the load steps of a static scene. Each is reported as soon as it is made; a
    /// checkpoint costs time, too, and comes when [`BETWEEN_CHECKPOINTS`] have passed.
    fn go_to_load(
        &mut self,
        writer: &mut Writer,
        checkpoint: impl Fn(&Self, usize) -> Checkpoint,
    ) -> Result<Option<Unreached>> {
        let mut made = self.done;
        let mut saved = Instant::now();
        let mut buckles = false;
        loop {
            let before = self.stepper.progress.last.last().cloned();
            let step = match self.next(1.0, "") {
                Ok(step) => step,
                Err(unreached) => return Ok(Some(unreached)),
            };
            made += 1;
            buckles = buckles || self.warn_of_buckling(before, &step);
            let at = step.iterate(self.problem, &self.scene.body.mesh.vertices);
            let cut = stability::ends_path(self.scene, made, &at, self.problem);
            let ends = step.ends_time_step || cut.is_some();
            if let Some(why) = cut.filter(|_| !step.ends_time_step) {
                log::info!("the path ends at {} {why}", self.scene.progress(step.time));
            }
            let due = !ends && saved.elapsed() >= BETWEEN_CHECKPOINTS;
            let checkpoint = due.then(|| checkpoint(self, made));
            if due {
                saved = Instant::now();
            }
            writer.send(Finished {
                steps: vec![step],
                reported: 0..1,
                velocity: None,
                checkpoint,
            })?;
            if ends {
                return Ok(None);
            }
        }
    }

    /// Warns where the body buckles near a load step that took many iterations; the state before it is none where it is the
    /// first.
    fn warn_of_buckling(&mut self, before: Option<Reached>, step: &LoadStep) -> bool {
        let rest = &self.scene.body.mesh.vertices;
        let (u, time) = before.map_or((vec![0.0; step.u.len()], 0.0), |b| (b.u, b.time));
        let at = Iterate { u: &u, time, ..step.iterate(self.problem, rest) };
        let solver = (self.problem, &mut self.workspace);
        let warning = buckling::foreseen(self.scene, solver, &at, step);
        warning.iter().for_each(|warning| log::warn!("{warning}"));
        warning.is_some()
    }

    /// The next load step towards the end of a time step.
    fn next(&mut self, end: f64, which: &str) -> Result<LoadStep, Unreached> {
        let rest = &self.scene.body.mesh.vertices;
        let (stepper, workspace) = (&mut self.stepper, &mut self.workspace);
        let step = match &mut self.follower {
            Some(follower) => follower.next(stepper, self.problem, workspace, rest)?,
            None => stepper.next(self.problem, workspace, rest, end)?,
        };
        let now = self.start.elapsed().as_secs_f64();
        let left = self.pace.left(step.time, now).filter(|_| self.follower.is_none());
        log::info!(
            "{which}{}  {:2} iterations, forces off balance by {:.1e} N  {:.1} s{}",
            self.scene.progress(step.time),
            step.newton_iterations,
            step.residual,
            now,
            left.map(|s| format!("  about {} left", about(s))).unwrap_or_default()
        );
        simulation::judge_step(&step);
        stability::in_words(&step).iter().for_each(|line| log::info!("{line}"));
        self.last = step.path.is_some().then(|| step.clone());
        if let (Some(states), true) = (&mut self.states, step.ends_time_step) {
            states.push(end, self.stepper.progress.integrator.last().clone());
        }
        Ok(step)
    }

    /// Writes what the run came to; the result is why it must not be used, if it must not. It began at some time, after
    /// some seconds, and took some until the equilibrium, as others were expected.
    fn end(
        &mut self,
        report: Simulation,
        folder: &Path,
        recorder: &Recorder,
        (since, before_s, [equilibrium_s, predicted_s]): (Instant, f64, [f64; 2]),
    ) -> Result<Option<String>> {
        let progress = &self.stepper.progress;
        let inertia = progress.integrator.method.has_inertia();
        let timings = self.workspace.timings;
        let spent = Spent {
            newton_iterations: progress.newton_iterations,
            velocity: inertia.then(|| &progress.integrator.last().v[..]),
            recorder,
            timings: &timings,
            equilibrium_s,
            predicted_s,
        };
        let end = self.stepper.iterate(self.problem, &self.scene.body.mesh.vertices);
        let (last, states) = (self.last.as_ref(), self.states.as_ref());
        let outcome = Outcome { end, last, states, spent, since, before_s };
        let solver = (self.problem, &mut self.workspace, self.probes);
        outcome.write(self.scene, solver, folder, report)
    }

    /// Writes the report of a run without an equilibrium; the result is what to say of it.
    fn failed(
        &mut self,
        mut report: Simulation,
        arguments: &Arguments,
        unreached: &Unreached,
    ) -> Result<anyhow::Error> {
        let (scene, folder) = (self.scene, &arguments.output);
        let rest = &scene.body.mesh.vertices;
        let unreached = &self.stepper.confirmed(self.problem, &mut self.workspace, rest, unreached);
        let solver = (self.problem, &mut self.workspace);
        let diagnosis = Diagnosis::new(scene, &scene.body, solver, unreached);
        diagnosis.write_state(folder)?;
        (report.status, report.usable) = (diagnosis.status, false);
        report.failed = Some(diagnosis.failed);
        results::write_report(folder, &report)?;
        Ok(Unusable(format!(
            "{}: {}\n  the state at {} is in {}; its array worst_element marks the element",
            arguments.scene.display(),
            diagnosis.message,
            scene.progress(unreached.time),
            folder.join(results::FAILED).display()
        ))
        .into())
    }
}

/// Where to keep all states of a run of which error bars are wanted.
fn all_states(scene: &Scene, stepper: &TimeStepper, done: usize) -> Option<Trajectory> {
    scene.config.uncertainty.as_ref()?;
    if done > 0 {
        log::warn!("no error bars: they need all states, and this run continues; see --restart");
        return None;
    }
    Some(Trajectory::begin(&stepper.progress.integrator, STATE_MEMORY))
}

/// Time steps that are to be made, of which a static scene has one.
fn steps_of(scene: &Scene, arguments: &Arguments, done: usize) -> Range<usize> {
    let count = scene.times().len();
    done..arguments.steps.map_or(count, |n| n.min(count))
}

/// What the states depend on: the scene, its meshes, the changes to it and what was measured.
fn hash_inputs(scene: &Scene, as_cast: Option<&Path>) -> Result<String> {
    let step = scene.config.solver.largest_load_step();
    let mut hashes = vec![scene.file.hash(), scene.config.degree.to_string(), step.to_string()];
    for part in &scene.parts {
        hashes.push(program::sha256_file(&part.mesh_path)?);
    }
    for obstacle in &scene.config.obstacle {
        let path = scene::config::beside(&scene.path, &obstacle.surface);
        hashes.push(program::sha256_file(&path)?);
    }
    if let Some(path) = as_cast {
        hashes.push(program::sha256_file(path)?);
    }
    Ok(hashes.join(" "))
}
