//! Backtracking line search: how far to go along a descent direction.
//!
//! The step is halved until the energy decreases by a fraction of what is predicted
//! (Armijo's condition). The first is the longest, up to 1, that continuous collision
//! detection allows.
//!
//! Source: Nocedal and Wright, "Numerical Optimization", chapter 3; test of
//! decrease near convergence: Hager and Zhang 2005, doi:10.1137/030601880.

use super::hessian_modification::Point;
use super::{Problem, Workspace};
use crate::energy::{Iterate, Nature};
use crate::math::linear::dot;

/// Fraction of the predicted decrease that a step must reach.
pub const ARMIJO: f64 = 1e-4;
/// Halvings of the step before the direction is given up.
const HALVINGS: usize = 30;
/// Shortest step that may increase the energy.
const LONG: f64 = 0.3;
/// Below this relative change the energy has no digits left to compare.
const ENERGY_DIGITS: f64 = 1e-9;

/// A trial state that was accepted, with its gradient if that was needed.
pub struct Accepted {
    /// The state [m].
    pub u: Vec<f64>,
    /// The energy [J].
    pub energy: f64,
    /// The gradient [N] and the scale of the forces [N].
    pub gradient: Option<(Vec<f64>, f64)>,
    /// Whether it decreases the energy as much as a step should.
    pub decreases: bool,
    /// Whether the step was not halved, and not much shortened by collision detection.
    pub is_long: bool,
}

/// Halves the step until it decreases the energy enough; where the energy has
/// no digits left, until the slope does not grow. None where no step does. A tolerant one takes a first step of
/// [`LONG`] at least, although it increases the energy, if that is elastic for the most part.
pub fn line_search(
    problem: &Problem,
    workspace: &mut Workspace,
    point: &Point,
    energy: f64,
    direction: &[f64],
    tolerant: bool,
) -> Option<Accepted> {
    let (at, slope) = (point.at, dot(point.gradient, direction));
    let whole: Vec<f64> = at.u.iter().zip(direction).map(|(u, d)| u + d).collect();
    let mut alpha = workspace.max_step(problem, &at, &Iterate { u: &whole, ..at });
    log::debug!("collision detection allows {alpha:.3} of the step");
    if alpha <= 0.0 {
        return None;
    }
    for halvings in 0..HALVINGS {
        let trial: Vec<f64> = at.u.iter().zip(direction).map(|(u, d)| u + alpha * d).collect();
        let there = Iterate { u: &trial, ..at };
        let value = workspace.value(problem, &there);
        let is_long = halvings == 0 && alpha >= LONG;
        if value <= energy + ARMIJO * alpha * slope {
            log::debug!("halved {halvings} times");
            let (gradient, decreases) = (None, true);
            return Some(Accepted { u: trial, energy: value, gradient, decreases, is_long });
        }
        if (value - energy).abs() <= ENERGY_DIGITS * energy.abs() {
            let gradient = workspace.gradient(problem, &there);
            let end = dot(&gradient.0, direction);
            if end.abs() <= (1.0 - ARMIJO) * slope.abs() {
                let (gradient, decreases) = (Some(gradient), true);
                return Some(Accepted { u: trial, energy: value, gradient, decreases, is_long });
            }
        }
        let increase = value - energy;
        if tolerant
            && is_long
            && increase.is_finite()
            && elastic_increase(problem, &at, &there) > 0.5 * increase
        {
            let times = increase / (0.5 * slope.abs());
            log::debug!("the energy grows by {times:.1} times what it was to fall");
            let (gradient, decreases) = (None, false);
            return Some(Accepted { u: trial, energy: value, gradient, decreases, is_long });
        }
        alpha *= 0.5;
    }
    None
}

/// How much more energy elastic bodies have in another state [J].
fn elastic_increase(problem: &Problem, from: &Iterate, to: &Iterate) -> f64 {
    let energy = |at: &Iterate| -> f64 {
        let terms = problem.energies.terms();
        terms.filter(|t| t.nature() == Nature::Elastic).map(|t| t.energy.value(at)).sum()
    };
    energy(to) - energy(from)
}
