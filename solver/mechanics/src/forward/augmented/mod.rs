//! Augmented Lagrangian for Dirichlet conditions: supports whose straight path would push
//! surfaces through each other.
//!
//! They are released and pulled to their places b by springs, while all forces balance
//! on paths that are free of contact,
//!
//! L(u, λ) = E(u) + Σ_i λ_i (u_i − b_i) + ½ s Σ_i k_i (u_i − b_i)²,
//! λ ← λ + s k (u − b)                                (the method of multipliers)
//!
//! until the straight rest of their path is free.
//!
//! i   released degrees of freedom: those of supports that are not at their place
//! k   diagonal of the projected Hessian [N/m] where they are released. It is
//!     positive for elements of every degree, unlike row sums of the mass of
//!     quadratic ones, and a spring is then as stiff as what it pulls
//! s   factor that grows where the distance left shrinks slowly [1]
//!
//! Obstacles have no degrees of freedom to release: where they are blocked, only
//! a shorter step helps.
//!
//! Sources: Nocedal and Wright, "Numerical Optimization", section 17.3; for moving
//! boundaries in contact Li et al. 2020, doi:10.1145/3386569.3392425.

use super::{Configuration, Newton, Problem, Workspace};
use crate::energy::{Hessian, Iterate, Spring, Springs};

/// Relative residual at which the multipliers are renewed.
const ROUGH: f64 = 1e-3;
/// Rough minima before the places count as out of reach.
const MINIMA: usize = 12;
/// First s.
const START: f64 = 10.0;
/// Springs become stiffer where more than this fraction of the distance is left ...
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

/// Pulls the supports to where they are at a time, from a state that surfaces can
/// reach at an earlier one; none where obstacles are blocked, or the places are
/// not reached. The residual of every iterate [N] is added to `residuals`.
pub(super) fn pull_supports(
    problem: &Problem,
    workspace: &mut Workspace,
    start: &Configuration,
    time: f64,
    newton: &Newton,
    residuals: &mut Vec<f64>,
) -> Option<Placed> {
    let before = start.iterate(problem);
    let at = Iterate { time, ..before };
    if workspace.max_step(problem, &before, &at) < 1.0 {
        return None;
    }
    let (fixed, places) = (problem.dirichlet.fixed(), problem.dirichlet.displacement(time));
    let is_released = |d: usize| fixed[d] && places[d] != start.u[d];
    let dofs: Vec<usize> = (0..fixed.len()).filter(|&d| is_released(d)).collect();
    if dofs.is_empty() {
        return None;
    }
    let kept: Vec<bool> = (0..fixed.len()).map(|d| fixed[d] && !is_released(d)).collect();
    let released = problem.with_fixed(&kept);
    let springs = stiff_springs(&released, workspace, &at, &dofs, &places);
    let state = Configuration { time, ..start.clone() };
    approach(&released, workspace, state, newton, springs, residuals)
}

/// Pulls the supports as [`pull_supports`] does, where they are released.
fn approach(
    released: &Problem,
    workspace: &mut Workspace,
    mut state: Configuration,
    newton: &Newton,
    mut springs: Springs,
    residuals: &mut Vec<f64>,
) -> Option<Placed> {
    let rough = Newton { relative: newton.relative.max(ROUGH), ..*newton };
    let (mut iterations, mut last) = (0, f64::INFINITY);
    for minimum in 0..MINIMA {
        let pulled = released.with_springs(springs.clone());
        let converged = rough.trace(&pulled, workspace, &mut state, residuals);
        iterations += converged.ok()?.iterations;
        let left = springs.longest(&state.u);
        log::debug!("augmented Lagrangian of the supports {minimum}  {left:.2e} m left");
        let at = state.iterate(released);
        let placed = springs.placed(&state.u);
        let there = Iterate { u: &placed, ..at };
        let free = workspace.max_step(released, &at, &there) >= 1.0;
        if free && workspace.value(released, &there).is_finite() {
            return Some(Placed { u: placed, iterations });
        }
        if left >= last {
            return None;
        }
        springs = springs.renewed(&state.u, if left > SLOW * last { GROWTH } else { 1.0 });
        last = left;
    }
    None
}

/// Springs that are [`START`] times as stiff as what they pull.
fn stiff_springs(
    released: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    dofs: &[usize],
    places: &[f64],
) -> Springs {
    let hessian = workspace.hessian(released, at, Hessian::Projected).lower;
    let diagonal: Vec<f64> = workspace.diagonal().iter().map(|&d| hessian[d]).collect();
    let stiffness = released.prolong(&diagonal);
    let spring = |&dof: &usize| Spring {
        dof,
        place: places[dof],
        stiffness: START * stiffness[dof],
        force: 0.0,
    };
    Springs::new(dofs.iter().map(spring).collect())
}

#[cfg(test)]
mod tests;
