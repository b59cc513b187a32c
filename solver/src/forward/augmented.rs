//! Supports whose straight way would push surfaces through each other.
//!
//! They are released and pulled to their places b by springs, while everything
//! balances on ways that are free,
//!
//! L(u, λ) = E(u) + Σ_i λ_i (u_i − b_i) + ½ s Σ_i k_i (u_i − b_i)²,
//! λ ← λ + s k (u − b)                                (the method of multipliers)
//!
//! until the straight rest of their way is free.
//!
//! i   released degrees of freedom: those of supports that are not at their place
//! k   diagonal of the projected Hessian [N/m] where they are released. It is
//!     positive for elements of every degree, unlike row sums of the mass of
//!     quadratic ones, and a spring is then as stiff as what it pulls
//! s   factor that grows where the way left shrinks slowly [1]
//!
//! Obstacles have no degrees of freedom to release: where they are blocked, only
//! a shorter step helps.
//!
//! Sources: Nocedal and Wright, "Numerical Optimization", section 17.3; for moving
//! boundaries in contact Li et al. 2020, doi:10.1145/3386569.3392425.

use mesh::Vec3;

use super::{Newton, System};
use crate::energy::{Hessian, Spring, Springs};

/// Relative residual at which the multipliers are renewed.
const ROUGH: f64 = 1e-3;
/// Rough minima before the places count as out of reach.
const MINIMA: usize = 12;
/// First s.
const START: f64 = 10.0;
/// A way of which more than this is left asks for stiffer springs ...
const SLOW: f64 = 0.25;
/// ... by this factor.
const GROWTH: f64 = 10.0;

/// A state with all supports at their places.
pub(super) struct Placed {
    /// Displacement [m].
    pub u: Vec<f64>,
    /// Newton iterations that it took.
    pub iterations: usize,
}

/// Pulls the supports to where they are at a load, from a state that surfaces can
/// reach at an earlier one; none where obstacles are blocked, or the places are
/// not reached. The residual of every iterate [N] is added to `residuals`.
pub(super) fn pull_supports(
    system: &mut System,
    rest: &[Vec3],
    (start, before): (&[f64], f64),
    load: f64,
    newton: &Newton,
    residuals: &mut Vec<f64>,
) -> Option<Placed> {
    if system.max_step(rest, (start, before), (start, load)) < 1.0 {
        return None;
    }
    let (fixed, places) = (system.fixed().to_vec(), system.displacement_of_supports(load));
    let released = |d: usize| fixed[d] && places[d] != start[d];
    let kept: Vec<bool> = (0..fixed.len()).map(|d| fixed[d] && !released(d)).collect();
    if kept == fixed {
        return None;
    }
    system.fix(&kept);
    let springs =
        springs(system, rest, (start, load), (0..fixed.len()).filter(|&d| released(d)), &places);
    let found = approach(system, rest, start, load, newton, springs, residuals);
    system.fix(&fixed);
    found
}

/// The same with the supports released.
fn approach(
    system: &mut System,
    rest: &[Vec3],
    start: &[f64],
    load: f64,
    newton: &Newton,
    mut springs: Springs,
    residuals: &mut Vec<f64>,
) -> Option<Placed> {
    let rough = Newton { relative: newton.relative.max(ROUGH), ..*newton };
    let (mut u, mut iterations, mut last) = (start.to_vec(), 0, f64::INFINITY);
    for minimum in 0..MINIMA {
        system.energies.springs = Some(springs.clone());
        let converged = rough.trace(system, rest, &mut u, load, residuals);
        system.energies.springs = None;
        iterations += converged.ok()?.iterations;
        let left = springs.longest(&u);
        log::debug!("supports pulled {minimum}  {left:.2e} m left");
        let placed = springs.placed(&u);
        let free = system.max_step(rest, (&u, load), (&placed, load)) >= 1.0;
        if free && system.value(rest, &placed, load).is_finite() {
            return Some(Placed { u: placed, iterations });
        }
        if left >= last {
            return None;
        }
        springs = springs.renewed(&u, if left > SLOW * last { GROWTH } else { 1.0 });
        last = left;
    }
    None
}

/// Springs with START times the stiffness of the Hessian where they pull.
fn springs(
    system: &mut System,
    rest: &[Vec3],
    (u, load): (&[f64], f64),
    dofs: impl Iterator<Item = usize>,
    places: &[f64],
) -> Springs {
    let hessian = system.hessian(rest, u, load, Hessian::Projected).lower;
    let diagonal: Vec<f64> = system.diagonal().iter().map(|&d| hessian[d]).collect();
    let stiffness = system.prolong(&diagonal);
    let spring = |dof: usize| Spring {
        dof,
        place: places[dof],
        stiffness: START * stiffness[dof],
        force: 0.0,
    };
    Springs::new(dofs.map(spring).collect())
}

#[cfg(test)]
mod tests;
