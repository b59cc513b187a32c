//! How an equilibrium follows its rest shape.

use mesh::Vec3;

use super::System;

/// Step of the one-sided difference, as a fraction of the motion. Truncation is
/// of this order, which is plenty for a prediction.
const STEP: f64 = 1e-5;

/// First-order change du = −H⁻¹ (∂²E/∂u∂X) dX [m] of the equilibrium `u` when
/// the rest vertices move by `motion` dX [m], under the full load. The system
/// has been linearised at `u`; none where the equilibrium is not stable.
pub fn follow(system: &mut System, rest: &[Vec3], u: &[f64], motion: &[Vec3]) -> Option<Vec<f64>> {
    if !system.linear.is_positive() {
        return None;
    }
    let moved: Vec<Vec3> = rest.iter().zip(motion).map(|(x, d)| x + STEP * d).collect();
    let (before, _) = system.gradient(rest, u, 1.0);
    let (after, _) = system.gradient(&moved, u, 1.0);
    let change: Vec<f64> = before.iter().zip(&after).map(|(b, a)| (b - a) / STEP).collect();
    let mut du = system.restrict(&change);
    system.linear.solve_to(&mut du, STEP);
    Some(system.prolong(&du))
}
