//! Sensitivity of an equilibrium to its rest shape: the tangent, or forward, derivative.

use mesh::Vec3;

use super::{Linearization, Problem, Workspace};
use crate::energy::Iterate;
use crate::math::linear::Factorization;

/// Step of the one-sided difference, as a fraction of the motion. Truncation is
/// of this order, which is plenty for a prediction.
const STEP: f64 = 1e-5;

/// First-order change du = −H⁻¹ (∂²E/∂u∂X) dX [m] of an equilibrium, linearised on its
/// rest shape X [m], when that moves by `motion` dX [m]; none where it is not stable, or
/// its linearisation is no longer that in the workspace.
pub fn follow(
    problem: &Problem,
    workspace: &mut Workspace,
    linearization: &Linearization,
    rest: &[Vec3],
    motion: &[Vec3],
) -> Option<Vec<f64>> {
    let at = linearization.iterate(problem, rest);
    let stable = workspace.linear().last().is_some_and(Factorization::is_positive);
    if !workspace.has_factor_of(linearization, &at) || !stable {
        return None;
    }
    let moved: Vec<Vec3> = rest.iter().zip(motion).map(|(x, d)| x + STEP * d).collect();
    let (before, _) = workspace.gradient(problem, &at);
    let (after, _) = workspace.gradient(problem, &Iterate { rest: &moved, ..at });
    let change: Vec<f64> = before.iter().zip(&after).map(|(b, a)| (b - a) / STEP).collect();
    let mut du = problem.restrict(&change);
    workspace.linear().last()?.solve_to(&mut du, STEP);
    Some(problem.prolong(&du))
}
