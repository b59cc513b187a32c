//! The cascade: levels with more and more handles, the body re-meshed in
//! between, every accepted iteration on disk.
//!
//! Source: Gjoka et al. 2024, section 4.5.

mod begin;
mod say;
mod step;
mod trial;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use mechanics::body::Body;
use mechanics::math::linear::norm;
use program::Unusable;
use reports::{Castable, Ended, Iteration, LevelEnd, NoStart, Optimization, Status, numbers};
use scene::config::{DesignConfig, ObjectiveConfig, OptimizerConfig, OptimizerMethod};
use scene::{ObjectiveBuilder, Scene};

use self::say::{say_gain, time_left, variables};
use self::step::projected_norm;
use super::checkpoint::Checkpoint;
use super::curvature::MOST_VARIABLES;
use super::ending::{End, Rejections, in_words};
use super::history::{History, handles, probes, scenarios, spread};
use super::molding::{self, Molding};
use super::remesh::write_bodies;
use super::shares;
use super::{Evaluation, Lbfgs, Level, Meshes, Rejected, Start};
use crate::report::failure::Diagnosis;
use crate::report::results;

/// Curvature pairs that L-BFGS remembers.
const MEMORY: usize = 6;
/// Fraction of the predicted decrease that a step must reach.
const ARMIJO: f64 = 1e-4;
/// Iterations that gain little, one after the other, before the level ends.
const QUIET: usize = 2;
/// How many times what ends a level a model promises that is taken for right, though the steps do not give it.
const PROMISES: f64 = 10.0;
/// Trials of a step before the level ends.
const TRIALS: usize = 10;
/// Trials that flat elements may cost in an iteration before the body is re-meshed.
const FLAT_TRIALS: usize = 2;
/// Name of the mesh of the shape that was accepted last, while a design is not finished.
pub const LATEST: &str = "latest";

/// Name of the mesh of the last shape that can be cast, where a design asks for that.
pub const CASTABLE: &str = "castable";

/// An optimisation in a folder.
pub struct Cascade<'a> {
    /// The scene that is simulated.
    pub scene: &'a Scene,
    /// The design problem.
    pub design: &'a DesignConfig,
    /// The body on the meshes of all levels.
    pub meshes: Meshes,
    /// Terms of the objective.
    pub objectives: &'a ObjectiveBuilder<'a>,
    /// Who is asked how shapes can be cast.
    pub molding: Option<Molding>,
    /// Where checkpoint, history and meshes go.
    pub folder: PathBuf,
    /// Hash of all inputs.
    pub inputs: String,
}

/// How the cascade ended.
pub struct Finished {
    /// The designed body.
    pub body: Body,
    /// The last level and its last evaluation.
    pub last: (Level, Evaluation),
    /// The variables.
    pub theta: Vec<f64>,
    /// How each level ended.
    pub endings: Vec<LevelEnd>,
    /// What a unit of each constraint is worth at the end, in its order.
    pub multipliers: Vec<f64>,
}

impl Finished {
    /// What was reached before a level that could not begin.
    fn without_level(mut self, level: usize, error: &anyhow::Error) -> Self {
        log::warn!("{error:#}; the design of the level before is kept");
        self.endings.push(LevelEnd { level, ending: Ended::NoEquilibrium, why: error.to_string() });
        self
    }
}

/// A trial step that was accepted.
struct Step {
    theta: Vec<f64>,
    evaluation: Evaluation,
    gradient: Vec<f64>,
    motion: f64,
    /// By how much the model said that the objective falls.
    predicted: f64,
    trials: usize,
    /// Flat elements have made it short.
    flat: bool,
    /// What was tried and not taken before it.
    rejections: Rejections,
    /// How the shape can be cast, where that is asked.
    mold: Option<Castable>,
    /// Nothing was known of the curvature.
    blind: bool,
    forward_s: f64,
    gradient_s: f64,
}

impl Cascade<'_> {
    /// Runs from the start, or from where the folder's checkpoint says.
    ///
    /// # Errors
    /// When a level does not fit the scene, the start is not admissible or something cannot be
    /// written.
    pub fn run(&self) -> Result<Finished> {
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
                let start = Checkpoint::new(self.inputs.clone(), Lbfgs::new(MEMORY));
                self.begin_mesh(&self.scene.body, self.meshes.others(), start)?
            }
        };
        let mut before: Option<Finished> = None;
        loop {
            let body = self.body_of(&checkpoint, None)?;
            let outcome = self.run_level(body, &mut checkpoint);
            let (level, evaluation) = match (outcome, before) {
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
                checkpoint = self.begin_level(next, &level, &evaluation, checkpoint)?;
            }
            let finished = Finished {
                body: level.shape(&evaluation),
                theta: reached.theta.clone(),
                endings: reached.all_endings(),
                multipliers: reached.multipliers,
                last: (level, evaluation),
            };
            if is_last {
                return Ok(finished);
            }
            before = Some(finished);
        }
    }

    /// How the shape of an evaluation can be cast, where that is asked and a shape moves.
    fn verdict(&self, level: &Level, at: &Evaluation) -> Result<Option<Castable>> {
        let asked = self.molding.as_ref().filter(|_| !level.map().moving().is_empty());
        asked.map(|molding| molding.ask(&level.shape(at))).transpose()
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
        let mut level = Level::new(&scene, self.objectives, body, self.design, settings)?;
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
            match self.iterate(&mut level, checkpoint, &current, &optimizer)? {
                Ok(step) => {
                    current = step.evaluation.clone();
                    self.accept(&mut level, checkpoint, step, &optimizer)?;
                }
                Err(End { rejections, .. })
                    if rejections.flat >= FLAT_TRIALS && checkpoint.has_moved() =>
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
        if !checkpoint.flat && settings.iterations > 0 {
            log::info!("{}", in_words(&checkpoint.end()));
        }
        if checkpoint.has_moved() && !checkpoint.flat {
            say_gain(checkpoint);
        }
        Ok((level, current))
    }

    /// The state to iterate from: solved at θ = 0, or read back.
    fn enter_level(&self, level: &mut Level, checkpoint: &mut Checkpoint) -> Result<Evaluation> {
        if !checkpoint.theta.is_empty() {
            checkpoint.check_sizes(&self.folder, level.variables())?;
            let rows = level.scenarios().len() * level.steps() + checkpoint.margins.len();
            let runs = checkpoint.read_runs(&self.folder, [rows, level.dofs()])?;
            let evaluation = level.recall(&checkpoint.theta, runs, &checkpoint.margins)?;
            level.linearize(&evaluation);
            return Ok(evaluation);
        }
        let theta = level.map().start(&checkpoint.loads);
        let context = || format!("level {}", checkpoint.level + 1);
        level.admit(&level.body.mesh.vertices).with_context(context)?;
        let theta = level.restored(&theta).with_context(context)?;
        level.admit(&level.map().shape(&theta)).with_context(|| {
            format!("level {}: moved to where its constraints are kept", checkpoint.level + 1)
        })?;
        let mut evaluation = match self.solve_near(level, &theta, checkpoint)? {
            Some(evaluation) => evaluation,
            None => match level.evaluate(&theta, Start::Rest) {
                Ok(evaluation) => evaluation,
                Err(rejected) => return Err(self.no_start(level, checkpoint.level, &rejected)),
            },
        };
        if checkpoint.weights.is_empty() {
            evaluation = level.weigh(&self.design.objective, evaluation).with_context(context)?;
            checkpoint.weights = level.weights();
        }
        let clock = Instant::now();
        level.linearize(&evaluation);
        evaluation.forward_s += clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let gradient = level.gradient(&theta, &evaluation).with_context(context)?;
        if checkpoint.history == 0 {
            self.say_what_is_not_felt(level, &theta, &evaluation)?;
        }
        let step = Step {
            theta,
            gradient,
            motion: 0.0,
            predicted: 0.0,
            trials: 1,
            flat: false,
            rejections: Rejections::default(),
            mold: self.verdict(level, &evaluation)?,
            blind: true,
            forward_s: evaluation.forward_s,
            gradient_s: clock.elapsed().as_secs_f64(),
            evaluation: evaluation.clone(),
        };
        self.record(level, checkpoint, step)?;
        Ok(evaluation)
    }

    /// Warns of terms that look at contact or at a probe and do not change with any variable: nothing leads them.
    fn say_what_is_not_felt(
        &self,
        level: &mut Level,
        theta: &[f64],
        at: &Evaluation,
    ) -> Result<()> {
        let asked = self.design.objective.iter();
        let asked = asked.filter(|term| term.kind().needs_contact || term.probe().is_some());
        for name in asked.map(ObjectiveConfig::name) {
            let swept = level.sweep(at, Some(name))?;
            if norm(&level.vjp(theta, &swept)) == 0.0 {
                log::warn!(
                    "objective \"{name}\" does not change with any variable at the start, so that the design cannot \
                     improve it: if it is a force, nothing touches there; begin from a shape or a pressure with which \
                     it does, or add an objective of kind \"distance\" or \"contact-proxy\" that leads there"
                );
            }
        }
        Ok(())
    }

    /// The error of a level whose body has no usable state. Where there is no
    /// equilibrium, report.json and the last good state say more.
    fn no_start(&self, level: &mut Level, index: usize, rejected: &Rejected) -> anyhow::Error {
        let Some(diagnosis) = level.diagnose() else {
            return Unusable(format!("level {}: {rejected}", index + 1)).into();
        };
        let written = diagnosis
            .write_state(&self.folder)
            .and_then(|()| self.write_failure(index, &diagnosis));
        if let Err(error) = written {
            return error;
        }
        Unusable(format!("level {}: {}", index + 1, diagnosis.message)).into()
    }

    /// Writes the report of a level that could not begin.
    fn write_failure(&self, index: usize, diagnosis: &Diagnosis) -> Result<()> {
        let status = match diagnosis.status {
            Status::NotEnoughSupports => Ended::NotEnoughSupports,
            _ => Ended::NoEquilibrium,
        };
        let failed = NoStart { level: index + 1, failed: diagnosis.failed.clone() };
        let report = Optimization { status, usable: false, designed: None, failed: Some(failed) };
        results::write_report(&self.folder, &report)
    }

    /// Takes a step over into the optimiser's memory and onto disk.
    fn accept(
        &self,
        level: &mut Level,
        checkpoint: &mut Checkpoint,
        step: Step,
        optimizer: &OptimizerConfig,
    ) -> Result<()> {
        let difference =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        checkpoint.lbfgs.update(
            difference(&step.theta, &checkpoint.theta),
            difference(&step.gradient, &checkpoint.gradient),
        );
        checkpoint.iteration += 1;
        // in the same checkpoint as the step: a kill between two would forget it
        let before = checkpoint.objective;
        let fall = (before - step.evaluation.objective) / before.abs();
        // once again right after a new mesh, it is not the mesh
        let held_back = step.flat && checkpoint.iteration > checkpoint.meshed_at + 1;
        // down the gradient, before anything is known of the curvature
        let is_quiet = fall < optimizer.stagnation && !held_back && !step.blind;
        checkpoint.quiet = if is_quiet { checkpoint.quiet + 1 } else { 0 };
        checkpoint.last_fall = fall;
        checkpoint.rejections.merge(step.rejections.clone());
        let mut ended = None;
        if checkpoint.quiet >= QUIET {
            // the model promises no more than it gave
            let ending = match step.predicted < PROMISES * optimizer.stagnation * before.abs() {
                true => Ended::Converged,
                false => Ended::Jammed,
            };
            let why =
                format!("the objective fell by only {fall:.1e} in each of {QUIET} iterations");
            ended = Some((ending, why));
        }
        let mut progress = checkpoint.progress.clone();
        progress.push(step.evaluation.objective, step.evaluation.newton_iterations);
        if let Some(rate) =
            progress.rate().filter(|rate| rate.max(0.0) < optimizer.least_rate && !held_back)
        {
            let why = format!(
                "a Newton iteration gains {:.1} % of what it gained on average in this level",
                100.0 * rate
            );
            ended = Some((Ended::StoppedEarly, why));
        }
        let left = projected_norm(level, &step.theta, &step.gradient) / checkpoint.first_gradient;
        if left < optimizer.gradient_tolerance {
            ended =
                Some((Ended::Converged, format!("the gradient fell to {left:.1e} of its first")));
        }
        let spent = checkpoint.spent_s + step.forward_s + step.gradient_s;
        if optimizer.time_limit.is_some_and(|limit| spent >= limit) {
            ended = Some((Ended::StoppedEarly, format!("{spent:.0} s were spent on the level")));
        }
        let left = self.design.levels()[checkpoint.level].iterations - checkpoint.iteration;
        checkpoint.flat = held_back && ended.is_none() && left > 0;
        checkpoint.ending = ended;
        self.record(level, checkpoint, step)
    }

    fn record(&self, level: &mut Level, checkpoint: &mut Checkpoint, step: Step) -> Result<()> {
        let levels = self.design.levels();
        let settings = &levels[checkpoint.level];
        let evaluation = &step.evaluation;
        checkpoint.spend(step.forward_s + step.gradient_s);
        // the same shape on another mesh is no progress
        if checkpoint.iteration == 0 || checkpoint.has_moved() {
            checkpoint.progress.push(evaluation.objective, evaluation.newton_iterations);
        }
        let gradient_norm = norm(&step.gradient);
        let moved = level.mean_displacements(evaluation)?;
        let measured = level.measured(evaluation)?;
        let several = !self.design.scenario.is_empty();
        let mut line = Iteration {
            level: checkpoint.level + 1,
            handles: handles(settings),
            variables: level.variables(),
            iteration: checkpoint.iteration,
            objective: Some(evaluation.objective),
            terms: numbers(&evaluation.terms),
            gradient_norm: Some(gradient_norm),
            motion_m: step.motion,
            trials: step.trials,
            newton_iterations: evaluation.newton_iterations,
            forward_s: step.forward_s,
            gradient_s: step.gradient_s,
            time_s: checkpoint.total_s,
            dofs: level.dofs(),
            time_steps: level.steps(),
            parameters: numbers(&level.map().parameters(&step.theta)),
            mean_displacement: numbers(&moved[0]),
            probes: probes(&measured[0]),
            scenarios: several.then(|| scenarios(level, evaluation, &moved, &measured)),
            spread: several.then(|| spread(&moved)),
            mold: None,
        };
        log::info!(
            "level {}/{} ({})  iteration {}/{}  objective {:.5e}, its gradient {gradient_norm:.2e}  \
             motion {:.2} mm  trials {}  Newton iterations {}  {:.1} + {:.1} s{}",
            checkpoint.level + 1,
            levels.len(),
            variables(level, settings),
            checkpoint.iteration,
            settings.iterations,
            evaluation.objective,
            1e3 * step.motion,
            step.trials,
            evaluation.newton_iterations,
            step.forward_s,
            step.gradient_s,
            time_left(&levels, checkpoint),
        );
        checkpoint.history += 1;
        if checkpoint.iteration == 0 {
            checkpoint.first_gradient = projected_norm(level, &step.theta, &step.gradient);
        }
        checkpoint.objective = evaluation.objective;
        if checkpoint.iteration == 0 {
            checkpoint.first_terms.clone_from(&evaluation.terms);
            if let Some(shares) = shares::describe(&evaluation.terms) {
                log::info!("level {} begins with {shares}", checkpoint.level + 1);
            }
        }
        if !level.map().moving().is_empty() {
            let shape = level.shape(&step.evaluation);
            write_bodies(&self.folder, LATEST, self.scene, &shape)?;
            if let Some(verdict) = &step.mold {
                molding::say(verdict, checkpoint.mold.as_ref());
                if let Castable::Planned { .. } = verdict {
                    write_bodies(&self.folder, CASTABLE, self.scene, &shape)?;
                }
            }
            line.mold.clone_from(&step.mold);
            checkpoint.mold = step.mold;
        }
        let Evaluation { runs, terms, .. } = step.evaluation;
        checkpoint.terms = terms;
        checkpoint.theta = step.theta;
        checkpoint.start.clear();
        checkpoint.gradient = step.gradient;
        // history first: a kill in between leaves one line too many, which the
        // next start removes
        self.history().append(&line)?;
        checkpoint.lines = self.history().sha256()?;
        checkpoint.write_with_runs(&self.folder, &runs)
    }
}
