//! Equilibria over time, reached in adaptive load steps.
//!
//! The load parameter is the time t. Time steps end at t₁ < t₂ < …; each is cut
//! into load steps where Newton's method needs them. A static scene is one time
//! step with t₁ = 1, where t is the fraction of the load.

use std::time::Instant;

use mesh::Vec3;
use serde::Serialize;

use super::augmented::pull_supports;
use super::volumes::balance;
use super::{Converged, Failure, Integrator, March, Method, Newton, State, System, certificate};
use crate::energy::Multiplier;
use crate::math::linear::norm;

/// Newton iterations after which a load step counts as easy.
pub(super) const EASY: usize = 5;
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
    let from = (start.to_vec(), 1.0);
    let step = attempt(system, rest, from, 1.0, newton).map_err(|failed| failed.failure)?;
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

/// Solves from the rest shape at t = 0 to the ends `times` of time steps without
/// inertia. `observe` is called after every accepted step.
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
    let zero = vec![0.0; system.len()];
    let start = State { u: zero.clone(), v: zero };
    let mut march = March::new(*stepping, Integrator::new(Method::Quasistatic, start));
    let mut steps = Vec::new();
    for &end in times {
        march.advance(system, rest, end, |step| {
            observe(step);
            steps.push(step.clone());
        })?;
    }
    let newton_iterations = march.progress.newton_iterations;
    Ok(Solution { u: march.progress.reached().to_vec(), steps, newton_iterations })
}

pub(super) fn loosened(newton: &Newton) -> Newton {
    Newton { relative: LOOSE * newton.relative, absolute: LOOSE * newton.absolute, ..*newton }
}

pub(super) struct Failed {
    pub failure: Failure,
    pub u: Vec<f64>,
    pub residuals: Vec<f64>,
}

/// One load step from a state that surfaces can reach at an earlier load: the
/// supports are moved, or pulled where their straight way is blocked, the forces
/// balanced, prescribed volumes reached and the state certified.
pub(super) fn attempt(
    system: &mut System,
    rest: &[Vec3],
    (start, before): (Vec<f64>, f64),
    load: f64,
    newton: &Newton,
) -> Result<LoadStep, Failed> {
    let mut u = start.clone();
    system.move_supports(rest, &mut u, load);
    let free = system.max_step(rest, (&start, before), (&u, load));
    let (mut residuals, mut pulling) = (Vec::new(), 0);
    if free < 1.0 {
        let around = pull_supports(system, rest, (&start, before), load, newton, &mut residuals);
        let Some(placed) = around else {
            return Err(Failed { failure: Failure::Blocked { free }, u: start, residuals });
        };
        (u, pulling) = (placed.u, placed.iterations);
    }
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
    match certify(system, rest, &u, load) {
        Ok(smallest_volume_ratio) => Ok(LoadStep {
            load,
            newton_iterations: pulling + iterations,
            residual,
            residual_wanted: wanted,
            rounding_floor: floor,
            smallest_volume_ratio,
            u,
            multipliers: system.multipliers.clone(),
            ends_time_step: false,
        }),
        Err(failure) => Err(Failed { failure, u, residuals }),
    }
}

/// A lower bound of J, if the body is nowhere turned inside out and no energy
/// objects.
fn certify(system: &mut System, rest: &[Vec3], u: &[f64], load: f64) -> Result<f64, Failure> {
    let start = Instant::now();
    let certified = certificate(&system.space, rest, u);
    system.timings.certificate_s += start.elapsed().as_secs_f64();
    let smallest = certified?;
    system.objection(rest, u, load).map_or(Ok(smallest), |what| Err(Failure::Objection(what)))
}

/// Norm of the unbalanced force [N]; infinite where it is not defined.
pub(super) fn residual(system: &mut System, rest: &[Vec3], u: &[f64], load: f64) -> f64 {
    let (gradient, _) = system.gradient(rest, u, load);
    let residual = norm(&system.restrict(&gradient));
    if residual.is_nan() { f64::INFINITY } else { residual }
}
