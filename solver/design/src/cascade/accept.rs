//! What follows from an accepted step: the memory of the optimiser, the end of the level, and what is written and said.

use anyhow::Result;
use mechanics::math::linear::norm;
use program::about;
use reports::{Castable, Ended, Iteration, numbers};
use scene::config::{LevelConfig, OptimizerConfig};
use variables::vectors::difference;

use super::step::promise;
use super::{CASTABLE, Cascade, LATEST, Step, Taken};
use crate::history::{handles, scenarios, spread};
use crate::meshes::write_bodies;
use crate::{Checkpoint, Evaluation, Level, molding, shares};

/// Iterations that gain little, one after the other, before the level ends.
const QUIET: usize = 2;
/// Motion over a mean edge along which the gradient is believed [1], ...
const NEAR: f64 = 0.1;
/// ... and the part of the objective that it promises there where a level is not at its minimum [1].
const STEEP: f64 = 0.1;
/// Part of what the design began with that is nothing left.
const NOTHING: f64 = 1e-5;
/// How many times what ends a level a model promises that is taken for right, though the steps do not give it.
const PROMISES: f64 = 10.0;

impl Taken {
    /// What it took [s].
    fn seconds(&self) -> f64 {
        self.forward_s + self.gradient_s + self.mold_s
    }
}

impl Cascade<'_> {
    /// Takes a step over into the optimiser's memory and onto disk; its evaluation.
    pub(super) fn accept(
        &self,
        level: &Level,
        checkpoint: &mut Checkpoint,
        step: Step,
        optimizer: &OptimizerConfig,
    ) -> Result<Evaluation> {
        checkpoint.lbfgs.update(
            difference(&step.taken.evaluation.theta, &checkpoint.theta),
            difference(&step.taken.gradient, &checkpoint.gradient),
        );
        checkpoint.iteration += 1;
        // in the same checkpoint as the step: a kill between two would forget it
        let before = checkpoint.merit;
        let merit = level.merit(&step.taken.evaluation, &checkpoint.penalties);
        let fall = (before - merit) / before.abs().max(NOTHING * checkpoint.first_merit.abs());
        // once again right after a new mesh, it is not the mesh
        let held_back = step.flat && checkpoint.iteration > checkpoint.meshed_at + 1;
        // down the gradient, before anything is known of the curvature
        let is_quiet = fall < optimizer.stagnation && !held_back && !step.blind;
        checkpoint.quiet = if is_quiet { checkpoint.quiet + 1 } else { 0 };
        checkpoint.quiet_rejections = match is_quiet {
            true => checkpoint.quiet_rejections + step.trials - 1,
            false => 0,
        };
        checkpoint.last_fall = fall;
        checkpoint.rejections.merge(step.rejections.clone());
        let mut ended = None;
        let near = NEAR * level.map.mean_edge;
        let (steepest, hoped) = promise(level, &step, &checkpoint.penalties, near);
        if checkpoint.quiet >= QUIET {
            // neither the model nor the gradient promises more, or nothing stood in the way
            let has_more = step.predicted >= PROMISES * optimizer.stagnation * before.abs()
                || hoped > STEEP * before.abs() && checkpoint.quiet_rejections > 0;
            let ending = if has_more { Ended::Jammed } else { Ended::Converged };
            let why =
                format!("the objective fell by only {fall:.1e} in each of {QUIET} iterations");
            ended = Some((ending, why));
        }
        let left = steepest / checkpoint.first_gradient;
        if left < optimizer.gradient_tolerance {
            ended =
                Some((Ended::Converged, format!("the gradient fell to {left:.1e} of its first")));
        }
        let spent = checkpoint.spent_s + step.taken.seconds();
        if optimizer.time_limit.is_some_and(|limit| spent >= limit) {
            ended = Some((Ended::StoppedEarly, format!("{spent:.0} s were spent on the level")));
        }
        let left = self.design.levels()[checkpoint.level].iterations - checkpoint.iteration;
        checkpoint.flat = held_back && ended.is_none() && left > 0;
        checkpoint.ending = ended;
        self.record(level, checkpoint, step)
    }

    /// Writes an accepted shape to disk, with its line of the history; its evaluation.
    pub(super) fn record(
        &self,
        level: &Level,
        checkpoint: &mut Checkpoint,
        step: Step,
    ) -> Result<Evaluation> {
        let levels = self.design.levels();
        let settings = &levels[checkpoint.level];
        checkpoint.spend(step.taken.seconds());
        if checkpoint.iteration == 0 {
            checkpoint.first_gradient = promise(level, &step, &checkpoint.penalties, 0.0).0;
        }
        let Step { taken, motion, trials, .. } = step;
        let Taken { evaluation, gradient, bounds, mold, .. } = taken;
        let gradient_norm = norm(&gradient);
        let runs = scenarios(level, &evaluation)?;
        let several = !self.design.scenario.is_empty();
        let line = Iteration {
            level: checkpoint.level + 1,
            handles: handles(settings),
            variables: level.variables(),
            iteration: checkpoint.iteration,
            objective: Some(evaluation.objective),
            terms: numbers(&evaluation.terms),
            gradient_norm: Some(gradient_norm),
            motion_m: motion,
            trials,
            newton_iterations: evaluation.newton_iterations,
            forward_s: taken.forward_s,
            gradient_s: taken.gradient_s,
            mold_s: mold.as_ref().map(|_| taken.mold_s),
            time_s: checkpoint.total_s,
            dofs: level.scenarios[0].problem.dofs(),
            time_steps: level.scenarios[0].times.len(),
            parameters: numbers(&level.map.parameters(&evaluation.theta)),
            mean_displacement: runs[0].1.mean_displacement.clone(),
            probes: runs[0].1.probes.clone(),
            spread: several.then(|| spread(&runs)),
            scenarios: several.then(|| runs.into_iter().collect()),
            mold: mold.clone(),
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
            1e3 * motion,
            trials,
            evaluation.newton_iterations,
            taken.forward_s,
            taken.gradient_s,
            time_left(&levels, checkpoint),
        );
        checkpoint.history += 1;
        checkpoint.merit = level.merit(&evaluation, &checkpoint.penalties);
        if checkpoint.iteration == 0 {
            checkpoint.merit_of_level = checkpoint.merit;
            checkpoint.first_terms.clone_from(&evaluation.terms);
            if let Some(shares) = shares::describe(&evaluation.terms) {
                log::info!("level {} begins with {shares}", checkpoint.level + 1);
            }
        }
        if !level.map.moving().is_empty() {
            let shape = level.shape(&evaluation);
            write_bodies(&self.folder, LATEST, self.scene, &shape)?;
            if let Some(verdict) = &mold {
                molding::say(verdict, checkpoint.mold.as_ref());
                if let Castable::Planned { .. } = verdict {
                    write_bodies(&self.folder, CASTABLE, self.scene, &shape)?;
                }
            }
            checkpoint.mold = mold;
        }
        checkpoint.terms.clone_from(&evaluation.terms);
        checkpoint.theta.clone_from(&evaluation.theta);
        checkpoint.start.clear();
        checkpoint.gradient = gradient;
        checkpoint.bounds = bounds;
        // history first: a kill in between leaves one line too many, which the
        // next start removes
        self.history().append(&line)?;
        checkpoint.lines = self.history().sha256()?;
        checkpoint.write_with_runs(&self.folder, &evaluation.runs)?;
        Ok(evaluation)
    }
}

/// Time for the iterations that are left, if they take as long as in this level.
fn time_left(levels: &[LevelConfig], checkpoint: &Checkpoint) -> String {
    if checkpoint.iteration == 0 {
        return String::new();
    }
    let all: usize = levels[checkpoint.level..].iter().map(|l| l.iterations).sum();
    let left = all.saturating_sub(checkpoint.iteration) as f64;
    let seconds = left * checkpoint.spent_s / (checkpoint.iteration + 1) as f64;
    format!("  about {} left", about(seconds))
}

/// Says what a level has gained, and whether one term has hidden the others.
pub(super) fn say_gain(checkpoint: &Checkpoint) {
    let level = checkpoint.level + 1;
    let first = checkpoint.merit_of_level;
    let gain = (first - checkpoint.merit) / first.abs();
    let costs = if checkpoint.bounds.is_empty() { "" } else { " with what violations cost" };
    log::info!("level {level} has lowered the objective{costs} by {:.2} %", 100.0 * gain);
    if let Some(hint) = shares::drowns(&checkpoint.first_terms, &checkpoint.terms) {
        log::warn!("level {level}: {hint}");
    }
}

/// Names the variables of loads that are held back by their bounds.
pub(super) fn say_bounds(level: &Level, checkpoint: &Checkpoint) {
    let Some((low, high)) = level.map.bounds(&checkpoint.theta) else { return };
    let first = level.map.shape_variables();
    let named = level.map.named_load_variables().iter().enumerate();
    let held: Vec<&str> = named
        .filter(|(k, _)| {
            let i = first + k;
            let (own, slope) = (checkpoint.theta[i], checkpoint.gradient[i]);
            let near = 1e-6 * (high[i] - low[i]);
            own - low[i] <= near && slope > 0.0 || high[i] - own <= near && slope < 0.0
        })
        .map(|(_, variable)| variable.path.as_str())
        .collect();
    if let [first, others @ ..] = &held[..] {
        let more = match others.len() {
            0 => String::new(),
            count => format!(" and {count} more"),
        };
        log::info!(
            "{first}{more}: at the bounds of the design, beyond which the objective would fall"
        );
    }
}

/// What changes in a level, for the log.
fn variables(level: &Level, settings: &LevelConfig) -> String {
    match settings.describe() {
        said if said.is_empty() => format!("{} variables of loads", level.variables()),
        said => said,
    }
}
