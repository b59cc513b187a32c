//! An iteration of the Gauss–Newton method: the step that minimises a quadratic model within a trust region.

use std::time::Instant;

use anyhow::{Result, ensure};
use mechanics::math::linear::{dot, norm};
use scene::config::OptimizerConfig;

use super::{ARMIJO, Cascade, End, FLAT_TRIALS, Step, TRIALS, ahead, lower};
use crate::optimize::checkpoint::Checkpoint;
use crate::optimize::curvature::Curvature;
use crate::optimize::level::Start;
use crate::optimize::trust_region::TrustRegion;
use crate::optimize::{Evaluation, Level, Rejected};

/// Variables for each step that a curvature is used for beyond the first: so many cost about as much as a trial.
const VARIABLES_PER_STEP: usize = 16;
/// Variables beyond which the first-order changes of all take too much time and memory.
const MOST_VARIABLES: usize = 400;
/// Radii that are tried until a rest shape is valid.
const RADII: usize = 12;

/// A step that the model proposes, with a valid rest shape.
struct Proposal {
    d: Vec<f64>,
    motion: f64,
    /// Radii at which elements were flat.
    flat: usize,
}

impl Cascade<'_> {
    /// One step within the trust region, and the model after it; the inner error is why there is none.
    pub(super) fn iterate_in_region(
        &self,
        level: &mut Level,
        checkpoint: &mut Checkpoint,
        current: &Evaluation,
        optimizer: &OptimizerConfig,
    ) -> Result<Result<Step, End>> {
        let (theta, gradient) = (checkpoint.theta.clone(), checkpoint.gradient.clone());
        if norm(&gradient) == 0.0 {
            return Ok(Err(End::because("the gradient is zero")));
        }
        let clock = Instant::now();
        let edge = level.map().mean_edge();
        let mut region = checkpoint.region.clone();
        if region.is_empty() {
            region.radius = region.radius.max(optimizer.first_step * edge);
        }
        let curvature = match renew(&mut region, level, &theta, current) {
            Ok(curvature) => curvature,
            Err(Rejected(why)) => return Ok(Err(End { reason: why, flat: false })),
        };
        let mut forward_s = clock.elapsed().as_secs_f64();
        let (mut reason, mut flat) = (String::new(), 0);
        for trials in 1..=TRIALS {
            let clock = Instant::now();
            let proposal = propose(level, &region, &theta, &gradient);
            let Proposal { d, motion, .. } = proposal;
            flat += proposal.flat;
            let change = region.change(&gradient, &d);
            if change.is_nan() || change >= 0.0 {
                return Ok(Err(End::because("no step within the bounds decreases the model")));
            }
            let there = moved(&theta, &d);
            let wanted = checkpoint.objective + ARMIJO * change;
            let outcome = match curvature.as_ref().filter(|_| level.is_transient()) {
                Some(curvature) => {
                    let foreseen = level.foreseen(&theta, &d, current, curvature)?;
                    lower(level, &there, Start::Foreseen(&foreseen), wanted)
                }
                None => {
                    let predicted = level.predict(&there, current);
                    let start = ahead(current, predicted.as_deref(), 1.0);
                    lower(level, &there, level.near(current, &start), wanted)
                }
            };
            forward_s += clock.elapsed().as_secs_f64();
            let clock = Instant::now();
            let refused = match outcome.and_then(|e| Ok((level.gradient(&there, &e)?, e))) {
                Ok((new, evaluation)) => {
                    let y: Vec<f64> = new.iter().zip(&gradient).map(|(a, b)| a - b).collect();
                    region.judge((evaluation.objective - checkpoint.objective) / change, motion);
                    region.radius = region.radius.min(optimizer.largest_step * edge);
                    region.update(&d, &y);
                    checkpoint.region = region;
                    // a step as long as the first of a level is not held back
                    let short = motion < optimizer.first_step * edge;
                    return Ok(Ok(Step {
                        theta: there,
                        evaluation,
                        gradient: new,
                        motion,
                        trials,
                        flat: short && flat >= FLAT_TRIALS,
                        forward_s,
                        gradient_s: clock.elapsed().as_secs_f64(),
                    }));
                }
                Err(refused) => refused,
            };
            log::info!("trial {trials} rejected: {}", refused.reason);
            region.radius = motion * refused.shorter(checkpoint.objective, dot(&gradient, &d));
            reason = refused.reason;
        }
        let reason = format!("no step was accepted in {TRIALS} trials, the last because: {reason}");
        Ok(Err(End { reason, flat: flat >= FLAT_TRIALS }))
    }
}

/// Refuses a level of so many variables that their curvature is out of reach.
pub(super) fn check_variables(level: &Level) -> Result<()> {
    let variables = level.variables();
    ensure!(
        variables <= MOST_VARIABLES,
        "{variables} variables, of which method = \"gauss-newton\" takes at most {MOST_VARIABLES}: expected fewer \
         handles, or method = \"l-bfgs\" in [optimizer]"
    );
    Ok(())
}

/// The curvature of the objective, where the model has none or an old one.
fn renew(
    region: &mut TrustRegion,
    level: &mut Level,
    theta: &[f64],
    current: &Evaluation,
) -> Result<Option<Curvature>, Rejected> {
    if region.is_good_for(theta.len() / VARIABLES_PER_STEP) {
        return Ok(None);
    }
    let found = level.curvature(theta, current)?;
    // changes of the first order grow without end where a motion does not forget its start
    let curvature = found.filter(|found| found.matrix.iter().all(|entry| entry.is_finite()));
    match &curvature {
        Some(curvature) => region.renew(&curvature.matrix),
        None if region.is_empty() => {
            let why = "the tangent of the start cannot be factored: it gives way there";
            return Err(Rejected(why.to_owned()));
        }
        None => log::debug!("the curvature of before is kept, as the tangent has no use"),
    }
    Ok(curvature)
}

/// The step of the model within the region, which shrinks until the rest shape is valid.
fn propose(level: &Level, region: &TrustRegion, theta: &[f64], gradient: &[f64]) -> Proposal {
    let metric = level.metric(theta);
    let bounds: Vec<[f64; 2]> = match level.map().bounds(theta) {
        None => vec![[f64::NEG_INFINITY, f64::INFINITY]; theta.len()],
        Some((low, high)) => {
            (0..theta.len()).map(|i| [low[i] - theta[i], high[i] - theta[i]]).collect()
        }
    };
    let motion = |d: &[f64]| level.map().motion(theta, &moved(theta, d));
    let (mut radius, mut flat) = (region.radius, 0);
    for _ in 1..RADII {
        let d = region.step(gradient, &bounds, &metric, radius, motion);
        let there = moved(theta, &d);
        let is_free = level.free_fraction(theta, &d) == 1.0;
        if is_free && level.admit(&level.map().shape(&there)).is_ok() {
            return Proposal { motion: motion(&d), d, flat };
        }
        flat += usize::from(level.is_flat(&there));
        radius = 0.5 * motion(&d).min(radius);
    }
    let d = region.step(gradient, &bounds, &metric, radius, motion);
    Proposal { motion: motion(&d), d, flat }
}

fn moved(theta: &[f64], d: &[f64]) -> Vec<f64> {
    theta.iter().zip(d).map(|(t, d)| t + d).collect()
}
