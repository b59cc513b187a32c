//! Equilibria over time, reached in adaptive load steps.
//!
//! The load parameter is the time t. Time steps end at t₁ < t₂ < …; each is cut
//! into load steps where Newton's method needs them. A static scene is one time
//! step with t₁ = 1, where t is the fraction of the load.

use std::time::Instant;

use mesh::Vec3;
use serde::Serialize;

use super::volumes::balance;
use super::{Converged, Failure, Newton, System, certificate};
use crate::energy::Multiplier;
use crate::math::linear::norm;

/// Newton iterations after which a load step counts as easy.
const EASY: usize = 5;
/// Residual of intermediate load steps relative to the final one's.
const LOOSE: f64 = 1e4;

/// How to approach the end of a time step, in fractions of it.
#[derive(Clone, Copy, Debug)]
pub struct Stepping {
    /// First increment of the first time step.
    pub first: f64,
    /// Largest increment.
    pub largest: f64,
    /// Smallest increment before giving up.
    pub smallest: f64,
    /// Stopping rule at the end of a time step.
    pub newton: Newton,
}

/// One accepted load step.
#[derive(Clone, Debug, Serialize)]
pub struct LoadStep {
    /// Load parameter: the time t [s]; in a static scene the fraction of the
    /// full load.
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
    /// Of the chambers with a prescribed volume.
    #[serde(skip)]
    pub multipliers: Vec<Multiplier>,
    /// Whether it is the end of a time step.
    #[serde(skip)]
    pub ends_time_step: bool,
}

/// An equilibrium and the way to it.
pub struct Solution {
    /// Displacement [m], three components per node.
    pub u: Vec<f64>,
    /// Accepted load steps; the last is the end of the last time step.
    pub steps: Vec<LoadStep>,
    /// All Newton iterations, those of rejected steps included.
    pub newton_iterations: usize,
}

/// No equilibrium at the end of a time step.
#[derive(Clone, Debug, thiserror::Error)]
#[error("no equilibrium beyond {:.1} % of the load: {failure}", 100.0 * load)]
pub struct Unreached {
    /// Last load that has an equilibrium.
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
    /// Load that was tried.
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

/// Solves under the full load from the rest shape: one time step of length 1.
///
/// # Errors
/// [`Unreached`] with the load that was reached.
pub fn solve(
    system: &mut System,
    rest: &[Vec3],
    stepping: &Stepping,
    observe: impl FnMut(&LoadStep),
) -> Result<Solution, Unreached> {
    solve_in_time(system, rest, stepping, &[1.0], observe)
}

/// Solves from the rest shape at t = 0 to the ends `times` of time steps, in load
/// steps that shrink where Newton fails and grow where it is easy. `observe` is
/// called after every accepted step.
///
/// # Errors
/// [`Unreached`] with the load that was reached.
pub fn solve_in_time(
    system: &mut System,
    rest: &[Vec3],
    stepping: &Stepping,
    times: &[f64],
    mut observe: impl FnMut(&LoadStep),
) -> Result<Solution, Unreached> {
    system.linear.forget();
    system.multipliers.iter_mut().for_each(|m| m.pressure = 0.0);
    let mut newton_iterations = 0;
    let mut steps: Vec<LoadStep> = Vec::new();
    let mut increment = stepping.first;
    let mut begin = 0.0;
    for &end in times {
        let mut done = 0.0; // fraction of the time step
        while done < 1.0 {
            let next = if done + increment > 1.0 - 1e-9 { 1.0 } else { done + increment };
            let ends = next >= 1.0;
            let load = if ends { end } else { begin + next * (end - begin) };
            let newton = if ends { stepping.newton } else { loosened(&stepping.newton) };
            let multipliers = system.multipliers.clone();
            let start = predict(system, rest, &steps, load, begin > 0.0);
            match attempt(system, rest, start, load, &newton) {
                Ok(step) => {
                    newton_iterations += step.newton_iterations;
                    if step.newton_iterations <= EASY {
                        increment = (1.5 * increment).min(stepping.largest);
                    }
                    done = next;
                    observe(&step);
                    steps.push(LoadStep { ends_time_step: ends, ..step });
                }
                Err(Failed { failure, u, residuals }) => {
                    newton_iterations += residuals.len().saturating_sub(1);
                    system.multipliers = multipliers;
                    increment *= 0.5;
                    log::debug!("load {load:.4} failed ({failure}); increment {increment:.4}");
                    if increment < stepping.smallest {
                        let last = steps.last().map_or(0.0, |step| step.load);
                        let reached = last_state(&steps, system.len());
                        let attempt = Box::new(Attempt { reached, load, u, residuals });
                        return Err(Unreached { load: last, failure, attempt });
                    }
                }
            }
        }
        begin = end;
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

/// One load step: the supports are moved, the forces balanced, prescribed
/// volumes reached and the state certified.
fn attempt(
    system: &mut System,
    rest: &[Vec3],
    mut u: Vec<f64>,
    load: f64,
    newton: &Newton,
) -> Result<LoadStep, Failed> {
    system.move_supports(rest, &mut u, load);
    let mut residuals = Vec::new();
    let converged = match balance(system, rest, &mut u, load, newton, &mut residuals) {
        Ok(converged) => converged,
        Err(failure) => return Err(Failed { failure, u, residuals }),
    };
    let Converged { iterations, residual, wanted, floor } = converged;
    if let Some(floor) = floor {
        log::warn!(
            "load {load:.4}: residual {residual:.1e} N instead of {wanted:.1e} N: it does not \
             fall further and rounding alone may leave {floor:.0e} N"
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
            multipliers: system.multipliers.clone(),
            ends_time_step: false,
        }),
        Err(failure) => Err(Failed { failure: failure.into(), u, residuals }),
    }
}

/// Linear extrapolation in the load from the last two states, pressures that hold
/// volumes included. Loads may bend where time steps meet, so `bent` asks whether
/// the last state itself is nearer to balance.
fn predict(
    system: &mut System,
    rest: &[Vec3],
    steps: &[LoadStep],
    load: f64,
    bent: bool,
) -> Vec<f64> {
    let len = system.len();
    let Some(b) = steps.last() else { return vec![0.0; len] };
    let zero = (0.0, &vec![0.0; len], &Vec::new());
    let a = if steps.len() > 1 { &steps[steps.len() - 2] } else { b };
    let a = if steps.len() > 1 { (a.load, &a.u, &a.multipliers) } else { zero };
    let t = (load - b.load) / (b.load - a.0);
    let further = |a: f64, b: f64| b + t * (b - a);
    let u: Vec<f64> = a.1.iter().zip(&b.u).map(|(a, b)| further(*a, *b)).collect();
    let before = |i: usize| a.2.get(i).map_or(0.0, |m| m.pressure);
    if bent && residual(system, rest, &b.u, load) <= residual(system, rest, &u, load) {
        return b.u.clone();
    }
    for (i, (m, b)) in system.multipliers.iter_mut().zip(&b.multipliers).enumerate() {
        m.pressure = further(before(i), b.pressure);
    }
    u
}

/// Norm of the unbalanced force [N]; infinite where it is not defined.
fn residual(system: &mut System, rest: &[Vec3], u: &[f64], load: f64) -> f64 {
    let (gradient, _) = system.gradient(rest, u, load);
    let residual = norm(&system.restrict(&gradient));
    if residual.is_nan() { f64::INFINITY } else { residual }
}
