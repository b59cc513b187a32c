//! Descent directions −H̃⁻¹g, from the most to the least trusted.
//!
//! What was measured (beam P2 at 50 kPa, gripper P1 at 60 kPa, frog P2 at 55 kPa,
//! from rest; Newton iterations / factorisations): points projected 13/9, 35/32,
//! 22/15; whole elements projected 15/10, 37/33, 22/15; projected and shifted at
//! once 15/8, 36/33; the exact Hessian shifted 16/10, 43/63; staying on the
//! projected rung for five more iterations 22/17 on the beam. No run left the last
//! rung without a step, so there is no gradient descent below it.

use std::time::Instant;

use mesh::Vec3;

use super::System;
use crate::energy::Hessian;
use crate::math::linear::{Precision, Symmetric, dot};

/// Relative residual that a direction by an indefinite factor may have.
const ACCURATE: f64 = 1e-6;

/// Where a direction comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rung {
    /// The exact Hessian, solved by conjugate gradients with an earlier factor.
    Near,
    /// The exact Hessian, factored.
    Exact,
    /// Projected elastic tangents.
    Projected,
    /// The same with a multiple of the identity added.
    Shifted,
}

impl Rung {
    /// The next one down, if any.
    pub fn below(self) -> Option<Self> {
        match self {
            Self::Near => Some(Self::Exact),
            Self::Exact => Some(Self::Projected),
            Self::Projected => Some(Self::Shifted),
            Self::Shifted => None,
        }
    }
}

/// What a rung may look at: one iterate and its gradient.
#[derive(Clone, Copy)]
pub struct Point<'a> {
    /// Rest vertices [m].
    pub rest: &'a [Vec3],
    /// Displacement [m].
    pub u: &'a [f64],
    /// Fraction of the load.
    pub load: f64,
    /// Gradient over all degrees of freedom [N].
    pub gradient: &'a [f64],
}

/// The first direction at `from` or below that a rung can give, and the rung.
/// None where the Hessian is not finite.
pub fn direction(
    system: &mut System,
    at: &Point,
    from: Rung,
    forcing: f64,
) -> Option<(Rung, Vec<f64>)> {
    let mut force = system.restrict(at.gradient);
    force.iter_mut().for_each(|d| *d = -*d);
    let found = if from <= Rung::Exact { exact(system, at, &force, from, forcing) } else { None };
    let (rung, free) = match found {
        Some(found) => found,
        None => projected(system, at, force, from, forcing)?,
    };
    Some((rung, system.prolong(&free)))
}

fn projected(
    system: &mut System,
    at: &Point,
    force: Vec<f64>,
    from: Rung,
    forcing: f64,
) -> Option<(Rung, Vec<f64>)> {
    let matrix = system.hessian(at.rest, at.u, at.load, Hessian::Projected);
    if from < Rung::Shifted && factor(system, matrix.clone()) {
        return Some((Rung::Projected, solve(system, force, forcing)));
    }
    factor_shifted(system, &matrix).then(|| (Rung::Shifted, solve(system, force, forcing)))
}

fn exact(
    system: &mut System,
    at: &Point,
    force: &[f64],
    rung: Rung,
    forcing: f64,
) -> Option<(Rung, Vec<f64>)> {
    let hessian = system.hessian(at.rest, at.u, at.load, Hessian::Exact);
    if rung == Rung::Near {
        let start = Instant::now();
        let near = system.linear.solve_near(&hessian, force, forcing);
        system.timings.solve_s += start.elapsed().as_secs_f64();
        if let Some(direction) = near {
            return Some((Rung::Near, direction));
        }
    }
    // where gas stiffens the body, the whole may be positive definite although
    // its sparse part is not
    let stiffened = hessian.updates.iter().any(|u| u.0 > 0.0).then(|| hessian.clone());
    if factor(system, hessian) {
        return Some((Rung::Exact, solve(system, force.to_vec(), forcing)));
    }
    let direction = indefinite(system, stiffened?, force)?;
    Some((Rung::Exact, direction))
}

/// H⁻¹f by an indefinite factor, if it is accurate and descends.
fn indefinite(system: &mut System, whole: Symmetric, force: &[f64]) -> Option<Vec<f64>> {
    let start = Instant::now();
    system.linear.factor_indefinite(whole);
    system.timings.factor_s += start.elapsed().as_secs_f64();
    system.timings.factorizations += 1;
    let start = Instant::now();
    let mut direction = force.to_vec();
    let residual = system.linear.solve(&mut direction);
    system.timings.solve_s += start.elapsed().as_secs_f64();
    (residual < ACCURATE && dot(force, &direction) > 0.0).then_some(direction)
}

fn solve(system: &mut System, mut force: Vec<f64>, forcing: f64) -> Vec<f64> {
    let start = Instant::now();
    system.linear.solve_to(&mut force, forcing);
    system.timings.solve_s += start.elapsed().as_secs_f64();
    force
}

fn factor(system: &mut System, matrix: Symmetric) -> bool {
    let start = Instant::now();
    let result = system.linear.factor_positive(matrix, Precision::Single);
    system.timings.factor_s += start.elapsed().as_secs_f64();
    system.timings.factorizations += 1;
    if let Err(error) = &result {
        system.timings.failed_factorizations += 1;
        log::debug!("{error}");
    }
    result.is_ok()
}

/// Adds ρ I, with ρ upwards by powers of ten, until the matrix is positive
/// definite, which ρ beyond its eigenvalues makes it if it is finite. Each
/// attempt costs a factorisation, so the first ρ is not small: the frog under
/// pressure needed 1e-5 of the largest diagonal entry, the gripper 1e-3.
fn factor_shifted(system: &mut System, matrix: &Symmetric) -> bool {
    let largest = system.diagonal().iter().map(|&d| matrix.lower[d].abs()).fold(0.0, f64::max);
    let mut shift = 1e-5 * largest;
    while shift.is_finite() && shift > 0.0 {
        let mut shifted = matrix.clone();
        for &d in system.diagonal() {
            shifted.lower[d] += shift;
        }
        if factor(system, shifted) {
            log::debug!("shifted by {:.0e} of the largest diagonal entry", shift / largest);
            return true;
        }
        shift *= 10.0;
    }
    false
}
