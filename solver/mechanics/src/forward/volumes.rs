//! Equilibria with prescribed volumes, by the augmented Lagrangian.
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

use nalgebra::{DMatrix, DVector, Dyn, LU};

use super::{Clock, Configuration, Converged, Failure, Newton, Problem, Workspace};
use crate::energy::{Constraint, Hessian, Iterate, Multiplier};
use crate::math::linear::{Precision, Symmetric, dot, norm};

/// Relative residual at which the constraints join in.
const ROUGH: f64 = 1e-4;
/// Rough minima before a volume counts as out of reach.
const MINIMA: usize = 30;
/// Most steps of Newton's method from one of them; a minimum follows if they do not
/// converge.
const STEPS: usize = 8;
/// The penalty grows where more than this fraction of a gap is left ...
const SLOW: f64 = 0.1;
/// ... by this factor.
const GROWTH: f64 = 10.0;
/// Relative residual of the linear systems, enough for quadratic convergence
/// from a rough minimum.
const LINEAR: f64 = 1e-6;

/// Moves displacement and multipliers to an equilibrium at which every prescribed
/// volume is reached to Newton's relative tolerance, with all Newton iterations; the
/// residual of every iterate [N] is added to `residuals`.
pub fn balance(
    problem: &Problem,
    workspace: &mut Workspace,
    state: &mut Configuration,
    newton: &Newton,
    residuals: &mut Vec<f64>,
) -> Result<Converged, Failure> {
    if state.multipliers.is_empty() {
        return newton.trace(problem, workspace, state, residuals);
    }
    let rough = Newton { relative: newton.relative.max(ROUGH), ..*newton };
    let (mut iterations, mut peak) = (0, 0.0_f64);
    let mut last = vec![f64::INFINITY; state.multipliers.len()];
    for minimum in 0.. {
        let least = rough.trace(problem, workspace, state, residuals)?;
        iterations += least.iterations;
        peak = peak.max(least.peak);
        let at = &state.iterate(problem);
        let mut distance = Distance::of(problem, workspace, at, newton, peak);
        for _ in 0..STEPS {
            if distance.is_reached() {
                break;
            }
            let nearer = joint_step(problem, workspace, state, newton, &distance);
            let Some(nearer) = nearer else { break };
            iterations += 1;
            residuals.push(nearer.residual);
            distance = nearer;
        }
        log::debug!(
            "augmented Lagrangian of the volumes {minimum}  largest gap {:.2e}",
            distance.largest_gap()
        );
        if distance.largest_gap() <= newton.relative {
            // what is left, if anything, are digits that rounding takes
            let converged = newton.trace(problem, workspace, state, residuals)?;
            iterations += converged.iterations;
            let at = &state.iterate(problem);
            distance = Distance::of(problem, workspace, at, newton, peak);
            if distance.largest_gap() <= newton.relative {
                return Ok(Converged { iterations, ..converged });
            }
        }
        if minimum == MINIMA {
            return Err(distance.failure());
        }
        for constraint in &distance.constraints {
            let multiplier = &mut state.multipliers[constraint.multiplier];
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

/// The multipliers of a state alone, whatever those of `at` are: the pressures P̂ that
/// minimise |∂L/∂u|, which at an equilibrium are the Lagrange multipliers of the
/// prescribed volumes.
pub fn solve_multipliers(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
) -> Vec<Multiplier> {
    let mut multipliers = problem.multipliers.clone();
    if multipliers.is_empty() {
        return multipliers;
    }
    let at = Iterate { multipliers: &problem.multipliers, ..*at };
    let (gradient, _) = workspace.gradient(problem, &at);
    let force = problem.restrict(&gradient);
    let constraints = problem.constraints(&at);
    let across: Vec<Vec<f64>> = constraints.iter().map(|c| problem.restrict(&c.gradient)).collect();
    let count = across.len();
    let matrix = DMatrix::from_fn(count, count, |i, j| dot(&across[i], &across[j]));
    let side = DVector::from_fn(count, |i, _| dot(&across[i], &force));
    let Some(pressures) = matrix.lu().solve(&side) else { return multipliers };
    for (constraint, pressure) in constraints.iter().zip(pressures.iter()) {
        multipliers[constraint.multiplier].pressure += pressure;
    }
    multipliers
}

/// How far a state is from an equilibrium with the prescribed volumes.
struct Distance {
    /// ∂L/∂u over all degrees of freedom [N].
    gradient: Vec<f64>,
    /// Norm of its free part [N].
    residual: f64,
    /// What that may be [N].
    wanted: f64,
    /// The largest scale of the forces so far [N].
    peak: f64,
    constraints: Vec<Constraint>,
    /// Largest gap allowed.
    tolerance: f64,
}

/// |V/V* − 1|
fn gap(constraint: &Constraint) -> f64 {
    (constraint.volume / constraint.wanted - 1.0).abs()
}

impl Distance {
    fn of(
        problem: &Problem,
        workspace: &mut Workspace,
        at: &Iterate,
        newton: &Newton,
        peak: f64,
    ) -> Self {
        let (gradient, scale) = workspace.gradient(problem, at);
        let peak = peak.max(scale);
        let residual = norm(&problem.restrict(&gradient));
        let wanted = newton.wanted(scale, peak);
        let constraints = problem.constraints(at);
        Self { gradient, residual, wanted, peak, constraints, tolerance: newton.relative }
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
    problem: &Problem,
    workspace: &mut Workspace,
    state: &mut Configuration,
    newton: &Newton,
    distance: &Distance,
) -> Option<Distance> {
    let at = state.iterate(problem);
    let (step, change) =
        direction(problem, workspace, &at, &distance.gradient, &distance.constraints)?;
    let u: Vec<f64> = state.u.iter().zip(&step).map(|(u, s)| u + s).collect();
    if workspace.max_step(problem, &at, &Iterate { u: &u, ..at }) < 1.0 {
        return None;
    }
    let mut multipliers = state.multipliers.clone();
    for (constraint, change) in distance.constraints.iter().zip(change.iter()) {
        multipliers[constraint.multiplier].pressure += change;
    }
    let trial = Configuration { u, multipliers, balanced_at: None, ..*state };
    let at = &trial.iterate(problem);
    let nearer = Distance::of(problem, workspace, at, newton, distance.peak);
    log::debug!(
        "newton with volumes  |g| {:.2e} N  largest gap {:.2e}",
        nearer.residual,
        nearer.largest_gap()
    );
    if nearer.measure() < distance.measure() {
        *state = trial;
        return Some(nearer);
    }
    None
}

/// The whole step of Newton's method on ∂L/∂u = 0 and V = V*, over all degrees of freedom [m], whether
/// it leads to an equilibrium or not; none where H is singular.
pub fn newton_step(problem: &Problem, workspace: &mut Workspace, at: &Iterate) -> Option<Vec<f64>> {
    let (gradient, _) = workspace.gradient(problem, at);
    let constraints = problem.constraints(at);
    direction(problem, workspace, at, &gradient, &constraints).map(|(step, _)| step)
}

/// δ and ΔP̂; none where H is singular.
fn direction(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    gradient: &[f64],
    constraints: &[Constraint],
) -> Option<(Vec<f64>, Vec<f64>)> {
    let hessian = workspace.hessian(problem, at, Hessian::Exact);
    let columns: Vec<Vec<f64>> =
        constraints.iter().map(|c| problem.restrict(&c.gradient)).collect();
    let mut sides = columns.clone();
    sides.push(problem.restrict(gradient).iter().map(|g| -g).collect());
    let mut solutions = solve_all(workspace, &hessian, &sides)?;
    let mut step = solutions.pop()?;
    let gap = |i: usize| constraints[i].wanted - constraints[i].volume;
    let change = HeldVolumes::new(columns, solutions).hold(&mut step, gap)?;
    Some((problem.prolong(&step), change))
}

/// What holds prescribed volumes: G, H⁻¹ G and Gᵀ H⁻¹ G over the unknowns.
pub struct HeldVolumes {
    across: Vec<Vec<f64>>,
    solved: Vec<Vec<f64>>,
    matrix: LU<f64, Dyn, Dyn>,
}

impl HeldVolumes {
    /// By the columns of G and of H⁻¹ G.
    pub fn new(across: Vec<Vec<f64>>, solved: Vec<Vec<f64>>) -> Self {
        let count = across.len();
        let matrix = DMatrix::from_fn(count, count, |i, j| dot(&across[i], &solved[j])).lu();
        Self { across, solved, matrix }
    }

    /// x ← x + H⁻¹ G w with Gᵀ x as wanted, and w; none where that is not defined.
    pub fn hold(&self, x: &mut [f64], wanted: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
        if self.across.is_empty() {
            return Some(Vec::new());
        }
        let side = DVector::from_fn(self.across.len(), |i, _| wanted(i) - dot(&self.across[i], x));
        let weights = self.matrix.solve(&side)?;
        for (z, weight) in self.solved.iter().zip(weights.iter()) {
            x.iter_mut().zip(z).for_each(|(x, z)| *x += weight * z);
        }
        Some(weights.iter().copied().collect())
    }
}

/// H⁻¹ of some vectors; none where H is singular.
fn solve_all(
    workspace: &mut Workspace,
    hessian: &Symmetric,
    sides: &[Vec<f64>],
) -> Option<Vec<Vec<f64>>> {
    let clock = Clock::start();
    let last = workspace.linear().last();
    let near = |side: &Vec<f64>| last?.solve_near(hessian, side, LINEAR).solved();
    let near: Option<Vec<_>> = sides.iter().map(near).collect();
    workspace.timings.solve += clock.elapsed();
    if near.is_some() {
        return near;
    }
    workspace.factor(|linear| linear.factor(hessian.clone(), Precision::Single).is_positive());
    let clock = Clock::start();
    let factored = workspace.linear().last();
    let exact = |side: &Vec<f64>| {
        let mut x = side.clone();
        (factored?.solve_to(&mut x, LINEAR) <= LINEAR).then_some(x)
    };
    let exact = sides.iter().map(exact).collect();
    workspace.timings.solve += clock.elapsed();
    exact
}
