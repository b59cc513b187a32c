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
use crate::energy::Iterate;
use crate::math::linear::dot;

/// Fraction of the predicted decrease that a step must reach.
const ARMIJO: f64 = 1e-4;
/// Halvings of the step before the direction is given up.
const HALVINGS: usize = 30;
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
}

/// Halves the step until it decreases the energy enough; where the energy has
/// no digits left, until the slope does not grow. None where no step does.
pub fn line_search(
    problem: &Problem,
    workspace: &mut Workspace,
    point: &Point,
    energy: f64,
    direction: &[f64],
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
        if value <= energy + ARMIJO * alpha * slope {
            log::debug!("halved {halvings} times");
            return Some(Accepted { u: trial, energy: value, gradient: None });
        }
        if (value - energy).abs() <= ENERGY_DIGITS * energy.abs() {
            let gradient = workspace.gradient(problem, &there);
            let end = dot(&gradient.0, direction);
            if end.abs() <= (1.0 - ARMIJO) * slope.abs() {
                return Some(Accepted { u: trial, energy: value, gradient: Some(gradient) });
            }
        }
        alpha *= 0.5;
    }
    None
}
