//! Equilibria with prescribed volumes.
//!
//! Newton's method finds a u that minimises the augmented Lagrangian
//!
//! L(u, P̂) = E(u) − Σ P̂ (V(u) − V*) + ½ k (V(u) − V*)²
//!
//! roughly. Beyond a limit point, where no pressure can be prescribed, its
//! quadratic term keeps it convex across the constraint. From there Newton's
//! method on ∂L/∂u = 0 and V = V* converges quadratically in u and P̂,
//!
//! H δ − G ΔP̂ = −∂L/∂u,   Gᵀ δ = V* − V,   G = ∂V/∂u
//!
//! Where it does not, P̂ ← P̂ − k (V − V*) and anew (the method of multipliers);
//! k grows if that is slow.
//!
//! Source: Nocedal and Wright, "Numerical Optimization", sections 17.3 and 18.1.

use std::time::Instant;

use mesh::Vec3;
use nalgebra::{DMatrix, DVector};

use super::{Converged, Failure, Newton, System};
use crate::energy::{Constraint, Hessian};
use crate::math::linear::{Precision, Symmetric, dot, norm};

/// Relative residual at which the constraints join in.
const ROUGH: f64 = 1e-4;
/// Rough minima before a volume counts as out of reach.
const MINIMA: usize = 30;
/// Steps of Newton's method from one of them, which converges or is of no use.
const STEPS: usize = 8;
/// A gap of which more than this is left asks for a larger penalty ...
const SLOW: f64 = 0.1;
/// ... by this factor.
const GROWTH: f64 = 10.0;
/// Relative residual of the linear systems, enough for quadratic convergence
/// from a rough minimum.
const LINEAR: f64 = 1e-6;

/// Moves `u` to an equilibrium at which every prescribed volume is reached to
/// Newton's relative tolerance, with all Newton iterations; the residual of
/// every iterate [N] is added to `residuals`.
///
/// # Errors
/// [`Failure`]; `u` is then the last state.
pub fn balance(
    system: &mut System,
    rest: &[Vec3],
    u: &mut Vec<f64>,
    load: f64,
    newton: &Newton,
    residuals: &mut Vec<f64>,
) -> Result<Converged, Failure> {
    if system.multipliers.is_empty() {
        return newton.trace(system, rest, u, load, residuals);
    }
    let rough = Newton { relative: newton.relative.max(ROUGH), ..*newton };
    let mut iterations = 0;
    let mut last = vec![f64::INFINITY; system.multipliers.len()];
    for minimum in 0.. {
        iterations += rough.trace(system, rest, u, load, residuals)?.iterations;
        let mut distance = Distance::of(system, rest, u, load, newton);
        for _ in 0..STEPS {
            if distance.is_reached() {
                break;
            }
            let Some(nearer) = joint_step(system, rest, u, load, newton, &distance) else { break };
            iterations += 1;
            residuals.push(nearer.residual);
            distance = nearer;
        }
        log::debug!("volumes {minimum}  largest gap {:.2e}", distance.largest_gap());
        if distance.largest_gap() <= newton.relative {
            // what is left, if anything, are digits that rounding takes
            let converged = newton.trace(system, rest, u, load, residuals)?;
            iterations += converged.iterations;
            distance = Distance::of(system, rest, u, load, newton);
            if distance.largest_gap() <= newton.relative {
                return Ok(Converged { iterations, ..converged });
            }
        }
        if minimum == MINIMA {
            return Err(distance.failure());
        }
        for constraint in &distance.constraints {
            let multiplier = &mut system.multipliers[constraint.multiplier];
            let last = &mut last[constraint.multiplier];
            multiplier.pressure -= multiplier.penalty * (constraint.volume - constraint.wanted);
            if gap(constraint) > newton.relative.max(SLOW * *last) {
                multiplier.penalty *= GROWTH;
            }
            *last = gap(constraint);
        }
    }
    unreachable!("the loop ends by returning")
}

impl System {
    /// Starts the multipliers anew, as before the first step.
    pub fn release_volumes(&mut self) {
        self.multipliers.clone_from(&self.multipliers_at_rest);
    }

    /// Sets the multipliers from a state alone: the pressures P̂ that minimise |∂L/∂u|,
    /// which at an equilibrium are those that hold the prescribed volumes.
    pub fn hold_volumes(&mut self, rest: &[Vec3], u: &[f64], load: f64) {
        if self.multipliers.is_empty() {
            return;
        }
        self.release_volumes();
        let (gradient, _) = self.gradient(rest, u, load);
        let force = self.restrict(&gradient);
        let constraints = self.constraints(rest, u, load);
        let across: Vec<Vec<f64>> =
            constraints.iter().map(|c| self.restrict(&c.gradient)).collect();
        let count = across.len();
        let matrix = DMatrix::from_fn(count, count, |i, j| dot(&across[i], &across[j]));
        let side = DVector::from_fn(count, |i, _| dot(&across[i], &force));
        let Some(pressures) = matrix.lu().solve(&side) else { return };
        for (constraint, pressure) in constraints.iter().zip(pressures.iter()) {
            self.multipliers[constraint.multiplier].pressure += pressure;
        }
    }
}

/// How far a state is from an equilibrium with the prescribed volumes.
struct Distance {
    /// ∂L/∂u over all degrees of freedom [N].
    gradient: Vec<f64>,
    /// Norm of its free part [N].
    residual: f64,
    /// What that may be [N].
    wanted: f64,
    constraints: Vec<Constraint>,
    /// Largest gap allowed.
    tolerance: f64,
}

/// |V/V* − 1|
fn gap(constraint: &Constraint) -> f64 {
    (constraint.volume / constraint.wanted - 1.0).abs()
}

impl Distance {
    fn of(system: &mut System, rest: &[Vec3], u: &[f64], load: f64, newton: &Newton) -> Self {
        let (gradient, scale) = system.gradient(rest, u, load);
        let residual = norm(&system.restrict(&gradient));
        let wanted = (newton.relative * scale).max(newton.absolute);
        let constraints = system.constraints(rest, u, load);
        Self { gradient, residual, wanted, constraints, tolerance: newton.relative }
    }

    fn largest_gap(&self) -> f64 {
        self.constraints.iter().map(gap).fold(0.0, f64::max)
    }

    fn is_reached(&self) -> bool {
        self.residual <= self.wanted && self.largest_gap() <= self.tolerance
    }

    /// Both parts relative to what is allowed.
    fn measure(&self) -> f64 {
        let residual = self.residual / self.wanted.max(f64::MIN_POSITIVE);
        residual.max(self.largest_gap() / self.tolerance)
    }

    fn failure(&self) -> Failure {
        let widest = self.constraints.iter().max_by(|a, b| gap(a).total_cmp(&gap(b)));
        let (volume, wanted) = widest.map_or((0.0, 0.0), |c| (c.volume, c.wanted));
        Failure::Volume { volume, wanted }
    }
}

/// One step of Newton's method in u and P̂; nothing changes if it does not come
/// nearer.
fn joint_step(
    system: &mut System,
    rest: &[Vec3],
    u: &mut Vec<f64>,
    load: f64,
    newton: &Newton,
    distance: &Distance,
) -> Option<Distance> {
    let hessian = system.hessian(rest, u, load, Hessian::Exact);
    let columns: Vec<Vec<f64>> =
        distance.constraints.iter().map(|c| system.restrict(&c.gradient)).collect();
    let mut sides = columns.clone();
    sides.push(system.restrict(&distance.gradient).iter().map(|g| -g).collect());
    let mut solutions = solve_all(system, &hessian, &sides)?;
    let free = solutions.pop()?;
    let count = columns.len();
    let matrix = DMatrix::from_fn(count, count, |i, j| dot(&columns[i], &solutions[j]));
    let side = DVector::from_fn(count, |i, _| {
        let constraint = &distance.constraints[i];
        constraint.wanted - constraint.volume - dot(&columns[i], &free)
    });
    let change = matrix.lu().solve(&side)?;
    let mut step = free;
    for (z, weight) in solutions.iter().zip(change.iter()) {
        step.iter_mut().zip(z).for_each(|(s, z)| *s += weight * z);
    }
    let step = system.prolong(&step);
    let trial: Vec<f64> = u.iter().zip(&step).map(|(u, s)| u + s).collect();
    if system.max_step(rest, (u, load), (&trial, load)) < 1.0 {
        return None;
    }
    let before = system.multipliers.clone();
    for (constraint, change) in distance.constraints.iter().zip(change.iter()) {
        system.multipliers[constraint.multiplier].pressure += change;
    }
    let nearer = Distance::of(system, rest, &trial, load, newton);
    log::debug!(
        "newton with volumes  |g| {:.2e} N  largest gap {:.2e}",
        nearer.residual,
        nearer.largest_gap()
    );
    if nearer.measure() < distance.measure() {
        *u = trial;
        return Some(nearer);
    }
    system.multipliers = before;
    None
}

/// H⁻¹ of some vectors; none where H is singular.
fn solve_all(
    system: &mut System,
    hessian: &Symmetric,
    sides: &[Vec<f64>],
) -> Option<Vec<Vec<f64>>> {
    let start = Instant::now();
    let near = |side: &Vec<f64>| system.linear.solve_near(hessian, side, LINEAR);
    let near: Option<Vec<_>> = sides.iter().map(near).collect();
    system.timings.solve_s += start.elapsed().as_secs_f64();
    if near.is_some() {
        return near;
    }
    let start = Instant::now();
    if system.linear.factor_positive(hessian.clone(), Precision::Single).is_err() {
        system.linear.factor_indefinite(hessian.clone());
    }
    system.timings.factor_s += start.elapsed().as_secs_f64();
    let start = Instant::now();
    let exact = |side: &Vec<f64>| {
        let mut x = side.clone();
        (system.linear.solve_to(&mut x, LINEAR) <= LINEAR).then_some(x)
    };
    let exact = sides.iter().map(exact).collect();
    system.timings.solve_s += start.elapsed().as_secs_f64();
    exact
}
