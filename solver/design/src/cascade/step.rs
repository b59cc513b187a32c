//! An iteration: the step that minimises a quadratic model under what a design keeps, within a trust region (sequential
//! quadratic programming).
//!
//! Every accepted shape keeps all constraints: a trial that violates one in the second order is moved back first, which
//! costs no run.

use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use mechanics::math::linear::{dot, norm};
use nalgebra::DMatrix;
use reports::Castable;
use scene::config::{OptimizerConfig, OptimizerMethod};
use variables::step::{Model, Problem, Row, TrustRegion, step_within};
use variables::vectors::{along, difference};

use super::{ARMIJO, Cascade, FLAT_TRIALS, Step, TRIALS, Taken};
use crate::bounds::raise;
use crate::checkpoint::Checkpoint;
use crate::curvature::Curvature;
use crate::ending::{Cause, End, Refused, Rejections};
use crate::scenario::Near;
use crate::{Evaluation, Level, Rejected};

/// Variables for each step that a curvature is used for beyond the first: so many cost about as much as a trial.
const VARIABLES_PER_STEP: usize = 16;
/// Radii that are tried until a rest shape is valid.
const RADII: usize = 12;
/// Fall of the objective, over what it is or was at the start of the design, that is none.
const ROUNDING: f64 = 1e-10;
/// How much longer than the region the step of a model of which nothing is known would be.
const UNKNOWN: f64 = 1e3;

/// A step that the model proposes, with a valid rest shape.
struct Proposal {
    d: Vec<f64>,
    /// In terms of the region.
    motion: f64,
    /// What the model says that the objective changes by.
    change: f64,
    /// What a unit of each constraint is worth, by its index.
    multipliers: Vec<f64>,
}

/// The model of an iteration.
struct Known {
    model: Model,
    /// The curvature that it was renewed with.
    curvature: Option<Curvature>,
    /// It is that of Gauss and Newton.
    from_terms: bool,
}

impl Cascade<'_> {
    /// One step within the trust region, and the model after it; the inner error is why there is none.
    pub(super) fn iterate(
        &self,
        level: &Level,
        checkpoint: &mut Checkpoint,
        current: &mut Evaluation,
        optimizer: &OptimizerConfig,
    ) -> Result<Result<Step, End>> {
        let (theta, gradient) = (current.theta.clone(), checkpoint.gradient.clone());
        let mut slope = gradient.clone();
        let bounded = level.bounded(&checkpoint.bounds, &checkpoint.penalties, &mut slope);
        if norm(&slope) == 0.0 {
            return Ok(Err(End::converged("the gradient is zero")));
        }
        let clock = Instant::now();
        let edge = level.map.mean_edge;
        let mut region = checkpoint.region.clone();
        let Known { model, curvature, from_terms } =
            match self.known(level, checkpoint, &mut region, current, optimizer) {
                Ok(known) => known,
                Err(rejected) => {
                    return Ok(Err(End::jammed(rejected.why, Rejections::default())));
                }
            };
        let mut forward_s = clock.elapsed().as_secs_f64();
        let mut rejections = Rejections::default();
        for trials in 1..=TRIALS {
            let clock = Instant::now();
            let at = (&theta[..], &slope[..], &bounded[..]);
            let proposal = propose(level, &model, region.radius, at, &mut rejections);
            let Some(Proposal { d, motion, change, multipliers }) = proposal else {
                let why = "no shape next to this one is valid and keeps the constraints";
                return Ok(Err(End::jammed(why.to_owned(), rejections)));
            };
            raise(&mut checkpoint.penalties, &multipliers[level.constraints.len()..]);
            checkpoint.multipliers = multipliers;
            let before = level.merit(current, &checkpoint.penalties);
            // less is rounding, of the objective at the start of the level as well
            let least = ROUNDING * before.abs().max(checkpoint.first_merit.abs());
            if change.is_nan() || -change <= least {
                return Ok(Err(End::converged("no step lowers the model of the objective")));
            }
            let there = along(&theta, &d, 1.0);
            let wanted = (before + ARMIJO * change, &checkpoint.penalties[..]);
            let outcome =
                lower(level, &there, &level.ahead(&d, current, curvature.as_ref())?, wanted);
            forward_s += clock.elapsed().as_secs_f64();
            let outcome = match outcome {
                Ok(evaluation) => {
                    // there is memory for those of others
                    current.runs.iter_mut().for_each(|run| run.tangents = Arc::default());
                    self.take(level, evaluation)?.map_err(Refused::from)
                }
                Err(refused) => Err(refused),
            };
            let refused = match outcome {
                Ok(Taken { mold: Some(Castable::Refused { refused }), .. })
                    if self.requires_mold() =>
                {
                    Refused::mold(&refused)
                }
                Ok(mut taken) => {
                    taken.forward_s += forward_s;
                    let merit = level.merit(&taken.evaluation, &checkpoint.penalties);
                    let agreement = (merit - before) / change;
                    let blind = !from_terms && checkpoint.lbfgs.is_empty();
                    // the length of a step of which nothing was known says nothing
                    region.judge(if blind { 1.0 } else { agreement }, motion);
                    if level.map.shape_variables() > 0 {
                        // variables of loads have bounds of their own
                        region.radius = region.radius.min(optimizer.largest_step * edge);
                    }
                    if from_terms {
                        region.update(&d, &difference(&taken.gradient, &gradient));
                    }
                    checkpoint.region = region;
                    let motion = level.map.motion(&theta, &there);
                    // a step as long as the first of a level is not held back
                    let short = motion < optimizer.first_step * edge;
                    return Ok(Ok(Step {
                        taken,
                        motion,
                        predicted: -change,
                        trials,
                        flat: short && rejections.count(Cause::Flat) >= FLAT_TRIALS,
                        rejections,
                        blind,
                    }));
                }
                Err(refused) => refused,
            };
            log::info!("trial {trials} rejected: {}", refused.why);
            rejections.add(refused.cause, &refused.why);
            region.radius = motion * refused.shorter(before, dot(&slope, &d));
        }
        let why = format!(
            "no step was accepted in {TRIALS} trials, the last because: {}",
            rejections.last
        );
        Ok(Err(End::jammed(why, rejections)))
    }

    /// The model of the objective at the state that was accepted last, and how far it is trusted.
    fn known(
        &self,
        level: &Level,
        checkpoint: &Checkpoint,
        region: &mut TrustRegion,
        current: &Evaluation,
        optimizer: &OptimizerConfig,
    ) -> Result<Known, Rejected> {
        let first = optimizer.first_step * level.map.mean_edge;
        let wants_terms = match optimizer.method {
            Some(method) => method == OptimizerMethod::GaussNewton,
            None => level.is_small() && self.design.is_of_squares(),
        };
        if wants_terms {
            if region.is_empty() {
                region.radius = region.radius.max(first);
            }
            let curvature = renew(region, level, current)?;
            if !region.is_empty() {
                let model = Model::full(region.matrix());
                return Ok(Known { model, curvature, from_terms: true });
            }
            log::info!("the tangent cannot be factored here: the model is from gradients alone");
        }
        let model = checkpoint.lbfgs.model();
        if model.is_none() {
            region.radius = first;
        }
        let unknown = || {
            let gradient = &checkpoint.gradient;
            Model::round(gradient.len(), norm(gradient) / (UNKNOWN * region.radius))
        };
        let model = model.unwrap_or_else(unknown);
        Ok(Known { model, curvature: None, from_terms: false })
    }
}

/// The evaluation at θ, if its merit with these penalties is at most `wanted`.
fn lower(
    level: &Level,
    theta: &[f64],
    near: &[Near],
    (wanted, penalties): (f64, &[f64]),
) -> Result<Evaluation, Refused> {
    let evaluation = level.evaluate(theta, near)?;
    let objective = level.merit(&evaluation, penalties);
    // a barrier with a negative weight may be −∞
    if !(objective.is_finite() && objective <= wanted) {
        let why = format!("objective {objective:.6e} is not low enough");
        return Err(Refused { cause: Cause::High, why, objective: Some(objective) });
    }
    Ok(evaluation)
}

/// The curvature of the objective, where the model has none or an old one.
fn renew(
    region: &mut TrustRegion,
    level: &Level,
    current: &Evaluation,
) -> Result<Option<Curvature>, Rejected> {
    if region.is_good_for(level.variables() / VARIABLES_PER_STEP) {
        return Ok(None);
    }
    let found = level.curvature(current)?;
    // changes of the first order grow without end where a motion does not forget its start
    let curvature = found.filter(|found| found.matrix.iter().all(|entry| entry.is_finite()));
    match &curvature {
        Some(curvature) => region.renew(&curvature.matrix),
        None => log::debug!("the curvature of before is kept, as the tangent has no use"),
    }
    Ok(curvature)
}

/// The step of the model within the region, in which the shape moves less and less far until it is valid; variables of
/// loads are not held back by that.
fn propose(
    level: &Level,
    model: &Model,
    radius: f64,
    (theta, gradient, bounded): (&[f64], &[f64], &[Row]),
    rejections: &mut Rejections,
) -> Option<Proposal> {
    let mut metric = match model.is_full() {
        true => level.map.metric(theta),
        false => DMatrix::zeros(0, 0),
    };
    let mut rows = level.kept_rows(theta, radius);
    rows.extend(level.open_rows(theta, radius));
    rows.extend(bounded.iter().cloned());
    let rows = with_bounds(level, theta, rows);
    let shape = level.map.shape_variables();
    // how many times shorter than the region the motion of the shape is
    let mut shorter = 1.0;
    for _ in 0..RADII {
        let motion = |d: &[f64]| level.map.scaled_motion(theta, &along(theta, d, 1.0), shorter);
        let problem = Problem::new(model, gradient, &metric, &rows, radius);
        let found = step_within(&problem, radius, &motion)?;
        let trial = level.restored(&within_bounds(level, theta, &found.d)).and_then(|there| {
            let d = difference(&there, theta);
            if level.free_fraction(theta, &d) < 1.0 {
                return Err(Rejected::new("the surface would pass through itself"));
            }
            level.check_flat(&there)?;
            level.admit(&level.map.shape(&there))?;
            Ok(d)
        });
        match trial {
            Ok(d) => {
                let mut multipliers = vec![0.0; level.constraints.len() + level.bounds().len()];
                for (k, multiplier) in &found.multipliers {
                    if let Some(index) = rows[*k].of {
                        multipliers[index] += multiplier;
                    }
                }
                let (change, motion) = (problem.change(&found.d), motion(&d));
                return Some(Proposal { motion, d, change, multipliers });
            }
            Err(refused) => {
                log::debug!("a shape is not tried: {refused}");
                let is_flat = level.check_flat(&along(theta, &found.d, 1.0)).is_err();
                rejections.add(if is_flat { Cause::Flat } else { Cause::Shape }, &refused.why);
                let cut = (2.0 * radius / motion(&found.d)).clamp(2.0, 1e3);
                shorter *= cut;
                // the region of a full model is kept by its metric
                let full = metric.nrows();
                (0..shape.min(full)).for_each(|i| {
                    (0..shape.min(full)).for_each(|j| metric[(i, j)] *= cut * cut);
                });
            }
        }
    }
    None
}

/// The inequalities of a step: those of the constraints, then the bounds of variables.
fn with_bounds(level: &Level, theta: &[f64], mut rows: Vec<Row>) -> Vec<Row> {
    rows.iter_mut().for_each(|row| row.c = row.c.max(0.0));
    let pressures = level.map.pressures_within(theta).into_iter();
    rows.extend(pressures.map(|(left, a)| Row { a, c: left.max(0.0), of: None }));
    if let Some((low, high)) = level.map.bounds(theta) {
        for (i, value) in theta.iter().enumerate() {
            for (sign, left) in [(1.0, value - low[i]), (-1.0, high[i] - value)] {
                if left.is_finite() {
                    rows.push(Row { a: vec![(i, sign)], c: left.max(0.0), of: None });
                }
            }
        }
    }
    rows
}

/// θ + d without what rounding has left beyond the bounds.
fn within_bounds(level: &Level, theta: &[f64], d: &[f64]) -> Vec<f64> {
    let mut there = along(theta, d, 1.0);
    if let Some((low, high)) = level.map.bounds(theta) {
        there.iter_mut().enumerate().for_each(|(i, value)| *value = value.clamp(low[i], high[i]));
    }
    there
}

/// The step down the gradient of the merit that the constraints and bounds leave.
fn downhill(level: &Level, step: &Step, penalties: &[f64]) -> Vec<f64> {
    let (theta, mut gradient) = (&step.taken.evaluation.theta, step.taken.gradient.clone());
    let mut kept = level.kept_rows(theta, 0.0);
    kept.extend(level.bounded(&step.taken.bounds, penalties, &mut gradient));
    kept.retain(|row| row.c <= level.tolerance(row));
    kept.iter_mut().for_each(|row| row.c = 0.0);
    let length = norm(&gradient);
    let all = with_bounds(level, theta, kept);
    let (model, metric) = (Model::round(gradient.len(), 1.0), DMatrix::zeros(0, 0));
    let problem = Problem::new(&model, &gradient, &metric, &all, length);
    problem.minimum(0.0).map_or(gradient, |found| found.d)
}

/// The largest component of that step, and by how much the merit would fall along it over a motion [m], to first order.
pub(super) fn promise(level: &Level, step: &Step, penalties: &[f64], motion: f64) -> (f64, f64) {
    let d = downhill(level, step, penalties);
    let (per_unit, largest) = level.map.motion_along(&step.taken.evaluation.theta, &d);
    if largest == 0.0 {
        return (0.0, 0.0);
    }
    (largest, dot(&d, &d) / per_unit * motion)
}
