//! Equilibrium under the full load, reached in adaptive load steps.

use std::time::Instant;

use mesh::Vec3;
use serde::Serialize;

use super::{Converged, Failure, Newton, System, certificate};

/// Newton iterations after which a load step counts as easy.
const EASY: usize = 5;
/// Residual of intermediate load steps relative to the final one's.
const LOOSE: f64 = 1e4;

/// How to approach the full load.
#[derive(Clone, Copy, Debug)]
pub struct Stepping {
    /// First increment as a fraction of the full load.
    pub first: f64,
    /// Largest increment.
    pub largest: f64,
    /// Smallest increment before giving up.
    pub smallest: f64,
    /// Stopping rule of the full load.
    pub newton: Newton,
}

/// One accepted load step.
#[derive(Clone, Debug, Serialize)]
pub struct LoadStep {
    /// Fraction of the full load.
    pub load: f64,
    /// Newton iterations.
    pub newton_iterations: usize,
    /// Norm of the unbalanced force [N].
    pub residual: f64,
    /// What was asked for [N].
    pub residual_wanted: f64,
    /// Where the residual is larger than that because rounding allows no less:
    /// its estimated floor [N].
    pub rounding_floor: Option<f64>,
    /// Lower bound of J = det(I + ∇u) over all points of all elements.
    pub smallest_volume_ratio: f64,
    /// Displacement [m], three components per node.
    #[serde(skip)]
    pub u: Vec<f64>,
}

/// An equilibrium and the way to it.
pub struct Solution {
    /// Displacement [m], three components per node.
    pub u: Vec<f64>,
    /// Accepted load steps; the last is the full load.
    pub steps: Vec<LoadStep>,
    /// All Newton iterations, those of rejected steps included.
    pub newton_iterations: usize,
}

/// No equilibrium under the full load.
#[derive(Clone, Debug, thiserror::Error)]
#[error("no equilibrium beyond {:.1} % of the load: {failure}", 100.0 * load)]
pub struct Unreached {
    /// Largest load that has an equilibrium, as a fraction.
    pub load: f64,
    /// What stopped the next step.
    pub failure: Failure,
    /// The states on both sides of it.
    pub attempt: Box<Attempt>,
}

/// A load step without an equilibrium.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The last equilibrium, or the rest shape [m].
    pub reached: Vec<f64>,
    /// Load that was tried, as a fraction.
    pub load: f64,
    /// The last iterate there [m].
    pub u: Vec<f64>,
    /// Residual of each iterate [N].
    pub residuals: Vec<f64>,
}

/// Solves under the full load from a nearby equilibrium, in one step. A factor
/// that the system still has is used, so that the result depends on it in its
/// last digits.
///
/// # Errors
/// [`Failure`] of Newton's method.
pub fn solve_from(
    system: &mut System,
    rest: &[Vec3],
    start: &[f64],
    newton: &Newton,
) -> Result<Solution, Failure> {
    let step =
        attempt(system, rest, start.to_vec(), 1.0, newton).map_err(|failed| failed.failure)?;
    let newton_iterations = step.newton_iterations;
    Ok(Solution { u: step.u.clone(), steps: vec![step], newton_iterations })
}

/// Solves under the full load from the rest shape, in load steps that shrink
/// where Newton fails and grow where it is easy. `observe` is called after
/// every accepted step.
///
/// # Errors
/// [`Unreached`] with the load that was reached.
pub fn solve(
    system: &mut System,
    rest: &[Vec3],
    stepping: &Stepping,
    mut observe: impl FnMut(&LoadStep),
) -> Result<Solution, Unreached> {
    system.linear.forget();
    let mut newton_iterations = 0;
    let mut steps: Vec<LoadStep> = Vec::new();
    let mut increment = stepping.first;
    let mut load = 0.0;
    while load < 1.0 {
        let next = if load + increment > 1.0 - 1e-9 { 1.0 } else { load + increment };
        let newton = if next < 1.0 { loosened(&stepping.newton) } else { stepping.newton };
        let start = predict(&steps, next, system.len());
        match attempt(system, rest, start, next, &newton) {
            Ok(step) => {
                newton_iterations += step.newton_iterations;
                if step.newton_iterations <= EASY {
                    increment = (1.5 * increment).min(stepping.largest);
                }
                load = next;
                observe(&step);
                steps.push(step);
            }
            Err(Failed { failure, u, residuals }) => {
                newton_iterations += residuals.len().saturating_sub(1);
                increment *= 0.5;
                log::debug!("load {next:.4} failed ({failure}); increment {increment:.4}");
                if increment < stepping.smallest {
                    let reached = last_state(&steps, system.len());
                    let attempt = Box::new(Attempt { reached, load: next, u, residuals });
                    return Err(Unreached { load, failure, attempt });
                }
            }
        }
    }
    let u = last_state(&steps, system.len());
    Ok(Solution { u, steps, newton_iterations })
}

fn last_state(steps: &[LoadStep], len: usize) -> Vec<f64> {
    steps.last().map_or_else(|| vec![0.0; len], |s| s.u.clone())
}

fn loosened(newton: &Newton) -> Newton {
    Newton { relative: LOOSE * newton.relative, absolute: LOOSE * newton.absolute, ..*newton }
}

struct Failed {
    failure: Failure,
    u: Vec<f64>,
    residuals: Vec<f64>,
}

/// One load step: the supports are moved, the forces balanced and the state
/// certified.
fn attempt(
    system: &mut System,
    rest: &[Vec3],
    mut u: Vec<f64>,
    load: f64,
    newton: &Newton,
) -> Result<LoadStep, Failed> {
    system.move_supports(rest, &mut u, load);
    let mut residuals = Vec::new();
    let converged = match newton.trace(system, rest, &mut u, load, &mut residuals) {
        Ok(converged) => converged,
        Err(failure) => return Err(Failed { failure, u, residuals }),
    };
    let Converged { iterations, residual, wanted, floor } = converged;
    if let Some(floor) = floor {
        log::warn!(
            "load {:.1} %: residual {residual:.1e} N instead of {wanted:.1e} N: it does not fall \
             further and rounding alone may leave {floor:.0e} N",
            100.0 * load
        );
    }
    let start = Instant::now();
    let certified = certificate(&system.space, rest, &u);
    system.timings.certificate_s += start.elapsed().as_secs_f64();
    match certified {
        Ok(smallest_volume_ratio) => Ok(LoadStep {
            load,
            newton_iterations: iterations,
            residual,
            residual_wanted: wanted,
            rounding_floor: floor,
            smallest_volume_ratio,
            u,
        }),
        Err(failure) => Err(Failed { failure: failure.into(), u, residuals }),
    }
}

/// Linear extrapolation in the load from the last two states.
fn predict(steps: &[LoadStep], load: f64, len: usize) -> Vec<f64> {
    let Some(b) = steps.last() else { return vec![0.0; len] };
    let rest = (0.0, &vec![0.0; len]);
    let a = if steps.len() > 1 {
        (steps[steps.len() - 2].load, &steps[steps.len() - 2].u)
    } else {
        rest
    };
    let t = (load - b.load) / (b.load - a.0);
    a.1.iter().zip(&b.u).map(|(a, b)| b + t * (b - a)).collect()
}
