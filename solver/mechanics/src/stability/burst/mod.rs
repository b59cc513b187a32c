//! The load at which a body bursts: its largest principal stretch is that at break,
//!
//! R(u, P̂, t) = 0,   V = V*,   s(u, X) = s_b
//!
//! with s that of [`LargestStretch`]. Newton's method on all of it converges quadratically from a state near by, also
//! where the tangent J of forces and volumes is nearly singular, as the row of s borders it. With the adjoint of s,
//! J (λ, μ) = (∂s/∂u, 0), a change of the equations by anything changes the load by
//!
//! dt = (∂s − λ · ∂R + μ · ∂(V − V*)) / c,   c = λ · ∂R/∂t − μ · ∂(V − V*)/∂t
//!
//! Near a limit point λ is a multiple of the mode φ and the part of ∂s is small beside it: dt becomes that of the limit.
//!
//! Source: the adjoint method, as in [`adjoint`](crate::adjoint); implicit function theorem.

mod search;

pub use search::{BurstSearch, FirstBurst};

use super::limit::Covector;
use super::spectrum::negative_eigenvalues;
use super::tangent_system::{LoadRate, Residual, Row, Step, at_held_load, by_multiplier, factor};
use crate::forward::{Configuration, Failure, Newton, Problem, Reached, Workspace};
use crate::math::linear::dot;
use crate::stretch::LargestStretch;

/// Newton iterations, at most.
const ITERATIONS: usize = 25;
/// Relative change of the load, and relative error of the stretch, that is none.
const SETTLED: f64 = 1e-9;

/// An equilibrium whose largest stretch is that at break.
#[derive(Clone, Debug)]
pub struct Burst {
    /// The state, by its load.
    pub at: Reached,
    /// Negative eigenvalues of the tangent: none where the body is stable.
    pub negative: usize,
    /// Newton iterations.
    pub iterations: usize,
    /// What makes changes of the equations a change of the load.
    pub covector: Covector,
    /// Change of the load by the rest vertices [1/m], beside that through the equations; three components per vertex.
    pub by_rest: Vec<f64>,
}

impl Burst {
    /// The state next to another one.
    pub fn near(
        problem: &Problem,
        workspace: &mut Workspace,
        start: &Configuration,
        at_break: f64,
        newton: &Newton,
    ) -> Result<Self, Failure> {
        let mut state = start.clone();
        let (mut peak, mut changed) = (0.0_f64, f64::INFINITY);
        for iterations in 0..=ITERATIONS {
            let at = state.iterate(problem);
            let now = Residual::of(problem, workspace, &at);
            peak = peak.max(now.scale);
            let (residual, wanted) = (now.norm(), newton.wanted(now.scale, peak));
            if !residual.is_finite() {
                return Err(Failure::Inadmissible);
            }
            let largest = LargestStretch::of(at.space, at.rest, at.u);
            let over = largest.value - at_break;
            log::debug!("burst {iterations}  |g| {residual:.2e} N  stretch {:.6}", largest.value);
            let placed = over.abs() <= SETTLED * at_break
                && changed <= SETTLED * state.time.abs()
                && now.largest_gap() <= newton.relative;
            if placed && (residual <= wanted || residual <= workspace.rounding_floor(problem, &at))
            {
                return Self::at(problem, workspace, &state, &largest, iterations);
            }
            if iterations == ITERATIONS {
                return Err(Failure::IterationLimit { iterations, residual, wanted });
            }
            let before = state.time;
            let (by_u, _) = largest.partials(at.space, at.rest, at.u);
            // supports are held
            let row = Row { u: problem.restrict(&by_u), load: 0.0 };
            let step = Step::newton(problem, workspace, &at, &now, row, over)?;
            state = step.cut(problem, workspace, &state);
            changed = (state.time - before).abs();
        }
        unreachable!("the last iteration returns")
    }

    /// What is known of a state that is found.
    fn at(
        problem: &Problem,
        workspace: &mut Workspace,
        state: &Configuration,
        largest: &LargestStretch,
        iterations: usize,
    ) -> Result<Self, Failure> {
        let at = state.iterate(problem);
        let constraints = problem.constraints(&at);
        let rate = LoadRate::of(problem, workspace, &at);
        let (by_u, mut by_rest) = largest.partials(at.space, at.rest, at.u);
        let factor = factor(problem, workspace, &at).ok_or(Failure::Inadmissible)?;
        let held = at_held_load(problem, factor, &constraints);
        let negative = negative_eigenvalues(factor, &held);
        let none = vec![0.0; constraints.len()];
        let found = held.solve(factor, &problem.restrict(&by_u), &none);
        let (lambda, pressures) = found.ok_or(Failure::Singular)?;
        let by_load = dot(&lambda, &rate.force) - dot(&pressures, &rate.gaps);
        if by_load == 0.0 || !by_load.is_finite() {
            return Err(Failure::Singular);
        }
        let pressures: Vec<f64> = pressures.iter().map(|pressure| pressure / by_load).collect();
        let mu = by_multiplier(state.multipliers.len(), &constraints, &pressures);
        by_rest.iter_mut().for_each(|by| *by /= by_load);
        let lambda: Vec<f64> = lambda.iter().map(|l| -1.0 / by_load * l).collect();
        let lambda = problem.prolong(&lambda);
        let at = Reached::of(&at);
        let covector = Covector { at: at.clone(), lambda, mu };
        Ok(Self { at, negative, iterations, covector, by_rest })
    }
}

#[cfg(test)]
mod tests;
