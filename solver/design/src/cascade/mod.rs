//! The cascade: levels with more and more handles, the body re-meshed in
//! between, every accepted iteration on disk.
//!
//! Source: Gjoka et al. 2024, section 4.5.

mod accept;
mod begin;
mod designed;
mod step;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::math::linear::norm;
use program::Unusable;
use reports::{Castable, Ended, LevelEnd, NoStart, Optimization, Status};
use scene::config::{DesignConfig, ObjectiveConfig, OptimizerMethod};
use scene::{ObjectiveBuilder, Scene};

use self::accept::{say_bounds, say_gain};
use super::bounds::BoundRow;
use super::checkpoint::Checkpoint;
use super::curvature::MOST_VARIABLES;
use super::ending::{Cause, End, Rejections, in_words};
use super::history::History;
use super::molding::Molding;
use super::{Evaluation, Level, Meshes, Problem, Rejected};
use run::report::results;

/// Fraction of the predicted decrease that a step must reach.
const ARMIJO: f64 = 1e-4;
/// Trials of a step before the level ends.
const TRIALS: usize = 10;
/// Trials that flat elements may cost in an iteration before the body is re-meshed.
const FLAT_TRIALS: usize = 2;
/// Name of the mesh of the shape that was accepted last, while a design is not finished.
const LATEST: &str = "latest";
/// Name of the mesh of the last shape that can be cast, where a design asks for that.
const CASTABLE: &str = "castable";

/// An optimisation in a folder.
pub struct Cascade<'a> {
    problem: &'a Problem,
    scene: &'a Scene,
    design: &'a DesignConfig,
    /// The body on the meshes of all levels.
    meshes: Meshes,
    objectives: ObjectiveBuilder<'a>,
    /// Who is asked how shapes can be cast.
    molding: Option<Molding>,
    /// Where checkpoint, history and meshes go.
    pub folder: PathBuf,
    /// Number of the start, of which 1 is the body as modelled.
    start: usize,
    /// Hash of all inputs.
    pub inputs: String,
}

/// How the cascade ended.
struct Finished {
    /// The last level ...
    level: Level,
    /// ... and its last evaluation.
    at: Evaluation,
    /// What was known there.
    checkpoint: Checkpoint,
    /// How each level ended.
    endings: Vec<LevelEnd>,
}

impl Finished {
    /// What was reached before a level that could not begin.
    fn without_level(mut self, level: usize, error: &anyhow::Error) -> Self {
        log::warn!("{error:#}; the design of the level before is kept");
        self.endings.push(LevelEnd { level, ending: Ended::NoEquilibrium, why: error.to_string() });
        self
    }
}

/// An evaluation with all that follows from it.
struct Taken {
    /// Linearised.
    evaluation: Evaluation,
    gradient: Vec<f64>,
    /// The bounds of its runs.
    bounds: Vec<BoundRow>,
    /// How the shape can be cast, where that is asked.
    mold: Option<Castable>,
    forward_s: f64,
    gradient_s: f64,
    mold_s: f64,
}

/// A step that was accepted.
struct Step {
    taken: Taken,
    motion: f64,
    /// By how much the model said that the objective falls.
    predicted: f64,
    trials: usize,
    /// Flat elements have made it short.
    flat: bool,
    /// What was tried and not taken before it.
    rejections: Rejections,
    /// Nothing was known of the curvature.
    blind: bool,
}

impl<'a> Cascade<'a> {
    /// The optimisation of a problem in a folder, from the start with this number.
    pub fn new(problem: &'a Problem, folder: &Path, start: usize) -> Result<Self> {
        let Problem { path, file, design, scene, .. } = problem;
        Ok(Self {
            molding: file.checked(|_| Molding::new(path, design, &scene.body))?,
            meshes: problem.meshes()?,
            objectives: problem.objectives()?,
            inputs: problem.hash()?,
            folder: folder.to_owned(),
            problem,
            scene,
            design,
            start,
        })
    }

    /// Runs from the start, or from where the folder's checkpoint says.
    fn run(&self) -> Result<Finished> {
        for (i, level) in self.design.levels().iter().enumerate() {
            let scene = self.scene.with_fidelity(level);
            scene
                .and_then(|scene| self.objectives.check_times(&scene))
                .with_context(|| format!("level {}", i + 1))?;
        }
        let mut checkpoint = match Checkpoint::read(&self.folder)? {
            Some(checkpoint) => {
                checkpoint.check_inputs(&self.folder, &self.inputs)?;
                checkpoint.check_files(&self.folder)?;
                checkpoint.remove_other_runs(&self.folder)?;
                log::info!(
                    "continuing at level {}, iteration {}",
                    checkpoint.level + 1,
                    checkpoint.iteration
                );
                self.history().truncate(checkpoint.history, &checkpoint.lines)?;
                checkpoint
            }
            None => {
                self.history().truncate(0, "")?;
                self.begin()?
            }
        };
        let mut before: Option<Finished> = None;
        loop {
            let body = self.body_of(&checkpoint, None)?;
            let outcome = self.run_level(body, &mut checkpoint);
            let (level, at) = match (outcome, before) {
                (Ok(reached), _) => reached,
                // nothing of what was reached is lost where a finer level cannot begin
                (Err(error), Some(before)) if error.is::<Unusable>() => {
                    return Ok(before.without_level(checkpoint.level + 1, &error));
                }
                (Err(error), _) => return Err(error),
            };
            let next = if checkpoint.flat { checkpoint.level } else { checkpoint.level + 1 };
            let reached = checkpoint.clone();
            let is_last = next == self.design.levels().len();
            if !is_last {
                checkpoint = self.begin_level(next, &level, &at, checkpoint)?;
            }
            let endings = reached.all_endings();
            let finished = Finished { level, at, checkpoint: reached, endings };
            if is_last {
                return Ok(finished);
            }
            before = Some(finished);
        }
    }

    /// Linearises an evaluation, differentiates it, and asks how its shape can be cast.
    fn take(&self, level: &Level, mut evaluation: Evaluation) -> Result<Result<Taken, Rejected>> {
        let clock = Instant::now();
        level.linearize(&mut evaluation);
        let forward_s = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let bounds = level.bound_rows(&evaluation);
        let found = bounds.and_then(|bounds| Ok((bounds, level.gradient(&evaluation)?)));
        let (bounds, gradient) = match found {
            Ok(found) => found,
            Err(rejected) => return Ok(Err(rejected)),
        };
        let gradient_s = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let asked = self.molding.as_ref().filter(|_| !level.map.moving().is_empty());
        let mold = asked.map(|molding| molding.ask(&level.shape(&evaluation))).transpose()?;
        let mold_s = clock.elapsed().as_secs_f64();
        Ok(Ok(Taken { evaluation, gradient, bounds, mold, forward_s, gradient_s, mold_s }))
    }

    /// Whether a shape that cannot be cast is no step.
    fn requires_mold(&self) -> bool {
        self.molding.as_ref().is_some_and(|molding| molding.required)
    }

    fn history(&self) -> History {
        History::new(&self.folder)
    }

    /// Iterates one level to its end.
    fn run_level(&self, body: Body, checkpoint: &mut Checkpoint) -> Result<(Level, Evaluation)> {
        let settings = &self.design.levels()[checkpoint.level];
        let optimizer = self.design.optimizer_of(settings);
        let scene = self.scene.with_fidelity(settings)?;
        let mut level = Level::new(&scene, &self.objectives, body, self.design, settings)?;
        ensure!(
            level.is_small() || optimizer.method != Some(OptimizerMethod::GaussNewton),
            "level {}: {} variables, of which method = \"gauss-newton\" takes at most {MOST_VARIABLES}: expected fewer \
             handles, or method = \"l-bfgs\"",
            checkpoint.level + 1,
            level.variables()
        );
        if !checkpoint.weights.is_empty() {
            level.set_weights(&checkpoint.weights);
        }
        let mut current = self.enter_level(&mut level, checkpoint)?;
        while checkpoint.iteration < settings.iterations
            && checkpoint.ending.is_none()
            && !checkpoint.flat
        {
            match self.iterate(&level, checkpoint, &mut current, &optimizer)? {
                Ok(step) => {
                    current = self.accept(&level, checkpoint, step, &optimizer)?;
                }
                Err(End { rejections, .. })
                    if rejections.count(Cause::Flat) >= FLAT_TRIALS && checkpoint.has_moved() =>
                {
                    checkpoint.flat = true;
                    checkpoint.write(&self.folder)?;
                }
                Err(End { ending, why, rejections }) => {
                    checkpoint.rejections.merge(rejections);
                    checkpoint.ending = Some((ending, why));
                    checkpoint.write(&self.folder)?;
                }
            }
        }
        if let Some(violated) = level.violated(&current).filter(|_| !checkpoint.flat) {
            log::info!("level {}: {violated}", checkpoint.level + 1);
        }
        if !checkpoint.flat && settings.iterations > 0 {
            log::info!("{}", in_words(&checkpoint.end()));
        }
        if checkpoint.has_moved() && !checkpoint.flat {
            say_gain(checkpoint);
            say_bounds(&level, checkpoint);
        }
        Ok((level, current))
    }

    /// The state to iterate from: solved at θ = 0, or read back.
    fn enter_level(&self, level: &mut Level, checkpoint: &mut Checkpoint) -> Result<Evaluation> {
        if !checkpoint.theta.is_empty() {
            let runs = checkpoint.read_runs(&self.folder)?;
            let mut evaluation = level.recall(&checkpoint.theta, runs)?;
            level.linearize(&mut evaluation);
            return Ok(evaluation);
        }
        let theta = level.map.start(&checkpoint.loads);
        let context = || format!("level {}", checkpoint.level + 1);
        let theta = beginning(level, &theta).map_err(|rejected| -> anyhow::Error {
            let said = format!("level {}: {rejected}", checkpoint.level + 1);
            // the design of the level before is kept
            if checkpoint.level > 0 { Unusable(said).into() } else { anyhow::anyhow!(said) }
        })?;
        let mut evaluation = match self.solve_near(level, &theta, checkpoint)? {
            Some(evaluation) => evaluation,
            None => match level.evaluate(&theta, &[]) {
                Ok(evaluation) => evaluation,
                Err(rejected) => return Err(self.no_start(level, checkpoint.level, &rejected)),
            },
        };
        if checkpoint.weights.is_empty() {
            evaluation = level.weigh(&self.design.objective, evaluation).with_context(context)?;
            checkpoint.weights = level.weights();
        }
        let forward_s = evaluation.forward_s;
        let mut taken = self.take(level, evaluation)?.with_context(context)?;
        taken.forward_s += forward_s;
        let at = &taken.evaluation;
        if checkpoint.penalties.is_empty() {
            checkpoint.penalties = level.first_penalties(at, norm(&taken.gradient));
            checkpoint.first_merit = level.merit(at, &checkpoint.penalties);
            checkpoint.began_outside = level.violated(at).is_some();
        }
        if checkpoint.history == 0 {
            self.say_what_is_not_felt(level, at)?;
        }
        let step = Step {
            taken,
            motion: 0.0,
            predicted: 0.0,
            trials: 1,
            flat: false,
            rejections: Rejections::default(),
            blind: true,
        };
        self.record(level, checkpoint, step)
    }

    /// Warns of terms that look at contact or at a probe and do not change with any variable: nothing leads them.
    fn say_what_is_not_felt(&self, level: &Level, at: &Evaluation) -> Result<()> {
        let asked = self.design.objective.iter();
        let asked = asked.filter(|term| term.kind().needs_contact || term.probe().is_some());
        for name in asked.map(ObjectiveConfig::name) {
            let swept = level.sweep(at, Some(name))?;
            if norm(&level.vjp(&at.theta, &swept)) == 0.0 {
                log::warn!(
                    "objective \"{name}\" does not change with any variable at the start, so that the design cannot \
                     improve it: if it is a force, nothing touches there; begin from a shape or a pressure with which \
                     it does, or add what leads there: an objective \"probe\" of a probe \"gap\" or \"distance\", or \"contact-proxy\""
                );
            }
        }
        Ok(())
    }

    /// The error of a level whose body has no usable state. Where there is no
    /// equilibrium, report.json and the last good state say more.
    fn no_start(&self, level: &Level, index: usize, rejected: &Rejected) -> anyhow::Error {
        let Some(diagnosis) = rejected.diagnose(&level.scenarios) else {
            return Unusable(format!("level {}: {rejected}", index + 1)).into();
        };
        let status = match diagnosis.status {
            Status::NotEnoughSupports => Ended::NotEnoughSupports,
            _ => Ended::NoEquilibrium,
        };
        let failed = NoStart { level: index + 1, failed: diagnosis.failed.clone() };
        let report = Optimization { status, usable: false, designed: None, failed: Some(failed) };
        let written = diagnosis.write_state(&self.folder);
        match written.and_then(|()| results::write_report(&self.folder, &report)) {
            Ok(()) => Unusable(format!("level {}: {}", index + 1, diagnosis.message)).into(),
            Err(error) => error,
        }
    }
}

/// The variables next to these that keep the constraints, of a valid shape.
fn beginning(level: &Level, theta: &[f64]) -> Result<Vec<f64>, Rejected> {
    level.admit(&level.body.mesh.vertices)?;
    let kept = level.restored(theta)?;
    let motion = level.map.vertex_motion(theta, &kept);
    if motion > 0.0 {
        log::info!(
            "the start is moved by up to {:.3} mm, to where its constraints are kept",
            1e3 * motion
        );
    }
    level.admit(&level.map.shape(&kept)).map_err(|rejected| {
        Rejected::new(format!("moved to where its constraints are kept: {rejected}"))
    })?;
    Ok(kept)
}
