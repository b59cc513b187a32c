//! Newton's method with a line search on the potential energy.
//!
//! H δ = −g, with H the exact Hessian while it is positive definite; else with
//! the elastic tangents projected; else with a multiple of the identity added
//! until it is. As long as it converges, the system is solved by conjugate
//! gradients with an earlier factor, to an accuracy that keeps convergence
//! superlinear (Dembo, Eisenstat and Steihaug 1982, doi:10.1137/0719025).
//!
//! Source: Nocedal and Wright, "Numerical Optimization", chapters 3 and 6; test
//! of decrease near convergence: Hager and Zhang 2005, doi:10.1137/030601880.

use std::time::Instant;

use mesh::Vec3;

use super::{System, Uncertified};
use crate::energy::Hessian;
use crate::math::linear::{Precision, Symmetric, dot, norm};

/// Fraction of the predicted decrease that a step must reach.
const ARMIJO: f64 = 1e-4;
/// Halvings of the step before the direction is given up.
const HALVINGS: usize = 30;
/// Relative accuracy of inexact steps, at most and at least.
const FORCING: (f64, f64) = (1e-2, 1e-6);
/// Below this relative change the energy has no digits left to compare.
const ENERGY_DIGITS: f64 = 1e-9;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Newton {
    /// Largest number of iterations.
    pub iterations: usize,
    /// Residual relative to the forces that balance.
    pub relative: f64,
    /// Residual below which any state counts as an equilibrium [N].
    pub absolute: f64,
}

/// Why there is no equilibrium. Not a panic: the caller decides.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The start is not admissible.
    #[error("the starting shape has inverted elements or an energy that is not finite")]
    Inadmissible,
    /// Too many iterations.
    #[error(
        "{iterations} Newton iterations were not enough: residual {residual:.2e} N, wanted {wanted:.2e} N"
    )]
    IterationLimit {
        /// Iterations made.
        iterations: usize,
        /// Residual reached [N].
        residual: f64,
        /// Residual asked for [N].
        wanted: f64,
    },
    /// No step decreases the energy.
    #[error(
        "no Newton step decreases the energy after {iterations} iterations: residual {residual:.2e} N, wanted {wanted:.2e} N"
    )]
    Stalled {
        /// Iterations made.
        iterations: usize,
        /// Residual reached [N].
        residual: f64,
        /// Residual asked for [N].
        wanted: f64,
    },
    /// The forces balance, but an element is turned inside out, or might be.
    #[error("the forces balance, but {0}")]
    Uncertified(#[from] Uncertified),
}

impl Newton {
    /// Moves `u` to an equilibrium and returns the iterations made and the
    /// residual [N] reached.
    ///
    /// # Errors
    /// [`Failure`]; `u` is then the last state.
    pub fn solve(
        &self,
        system: &mut System,
        rest: &[Vec3],
        u: &mut Vec<f64>,
        load: f64,
    ) -> Result<(usize, f64), Failure> {
        let mut energy = system.value(rest, u, load);
        if !energy.is_finite() {
            return Err(Failure::Inadmissible);
        }
        let (mut gradient, mut scale) = system.gradient(rest, u, load);
        let mut before = f64::INFINITY;
        for iterations in 0.. {
            let residual = norm(&system.restrict(&gradient));
            let wanted = (self.relative * scale).max(self.absolute);
            log::debug!("newton {iterations}  |g| {residual:.2e} N  energy {energy:.9e} J");
            if residual <= wanted {
                return Ok((iterations, residual));
            }
            if iterations == self.iterations {
                return Err(Failure::IterationLimit { iterations, residual, wanted });
            }
            let forcing = (residual / before).powi(2).clamp(FORCING.1, FORCING.0);
            before = residual;
            let direction = descent(system, rest, u, load, &gradient, forcing);
            let slope = dot(&gradient, &direction);
            let stalled = Failure::Stalled { iterations, residual, wanted };
            let step = line_search(system, rest, u, load, (energy, slope), &direction);
            let Some(accepted) = step else { return Err(stalled) };
            *u = accepted.u;
            energy = accepted.energy;
            (gradient, scale) = match accepted.gradient {
                Some(known) => known,
                None => system.gradient(rest, u, load),
            };
        }
        unreachable!("the loop ends by returning")
    }
}

/// −H⁻¹g with H made positive definite if it is not.
fn descent(
    system: &mut System,
    rest: &[Vec3],
    u: &[f64],
    load: f64,
    gradient: &[f64],
    forcing: f64,
) -> Vec<f64> {
    let exact = system.hessian(rest, u, load, Hessian::Exact);
    let mut direction = system.restrict(gradient);
    direction.iter_mut().for_each(|d| *d = -*d);
    let start = Instant::now();
    let near = system.linear.solve_near(&exact, &direction, forcing);
    system.timings.solve_s += start.elapsed().as_secs_f64();
    if let Some(direction) = near {
        return system.prolong(&direction);
    }
    if !factor(system, exact) {
        let projected = system.hessian(rest, u, load, Hessian::Projected);
        factor_shifted(system, &projected);
    }
    let start = Instant::now();
    system.linear.solve_to(&mut direction, forcing);
    system.timings.solve_s += start.elapsed().as_secs_f64();
    system.prolong(&direction)
}

fn factor(system: &mut System, matrix: Symmetric) -> bool {
    let start = Instant::now();
    let result = system.linear.factor_positive(matrix, Precision::Single);
    system.timings.factor_s += start.elapsed().as_secs_f64();
    if let Err(error) = &result {
        log::debug!("{error}");
    }
    result.is_ok()
}

/// Adds ρ I, with ρ from nothing upwards by powers of ten, until the matrix is
/// positive definite. Ends because ρ passes every eigenvalue of a finite matrix.
/// Each attempt costs a factorisation, so the first ρ > 0 is not small: the frog
/// under pressure needed 1e-4 of the largest diagonal entry.
fn factor_shifted(system: &mut System, matrix: &Symmetric) {
    let largest = system.diagonal().iter().map(|&d| matrix.lower[d].abs()).fold(0.0, f64::max);
    let mut shift = 0.0;
    loop {
        let mut shifted = matrix.clone();
        for &d in system.diagonal() {
            shifted.lower[d] += shift;
        }
        if factor(system, shifted) {
            return;
        }
        shift = if shift == 0.0 { 1e-5 * largest } else { 10.0 * shift };
    }
}

/// A trial state that was accepted, with its gradient if that was needed.
struct Accepted {
    u: Vec<f64>,
    energy: f64,
    gradient: Option<(Vec<f64>, f64)>,
}

/// Halves the step until it decreases the energy enough; where the energy has
/// no digits left, until the slope does not grow.
fn line_search(
    system: &mut System,
    rest: &[Vec3],
    u: &[f64],
    load: f64,
    (energy, slope): (f64, f64),
    direction: &[f64],
) -> Option<Accepted> {
    let mut alpha = 1.0;
    for _ in 0..HALVINGS {
        let trial: Vec<f64> = u.iter().zip(direction).map(|(u, d)| u + alpha * d).collect();
        let value = system.value(rest, &trial, load);
        if value <= energy + ARMIJO * alpha * slope {
            return Some(Accepted { u: trial, energy: value, gradient: None });
        }
        if (value - energy).abs() <= ENERGY_DIGITS * energy.abs() {
            let gradient = system.gradient(rest, &trial, load);
            let end = dot(&gradient.0, direction);
            if end.abs() <= (1.0 - ARMIJO) * slope.abs() {
                return Some(Accepted { u: trial, energy: value, gradient: Some(gradient) });
            }
        }
        alpha *= 0.5;
    }
    None
}
