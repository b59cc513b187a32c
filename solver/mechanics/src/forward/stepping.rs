//! Equilibria over time, reached in adaptive load steps: incremental loading, a homotopy
//! (continuation) in the load parameter.
//!
//! The load parameter is the time t. Time steps end at t₁ < t₂ < …; each is cut
//! into load steps where Newton's method needs them. A static scene is one time
//! step with t₁ = 1, where t is the fraction of the load.

use std::sync::Arc;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use super::augmented::pull_supports;
use super::path_point::ArcPoint;
use super::volumes::balance;
use super::watch::Event;
use super::{
    Clock, Configuration, Converged, Failure, Integrator, Method, Newton, Problem, Reached, State,
    TimeStepper, Workspace, certificate,
};
use crate::energy::{Iterate, Multiplier, TimeStep};
use crate::math::linear::norm;

/// Newton iterations after which a load step counts as easy.
pub(super) const EASY: usize = 5;
/// Growth of the increment after an easy load step.
pub const GROWTH: f64 = 1.5;
/// Residual of intermediate load steps relative to the final one's.
const LOOSE: f64 = 1e4;

/// How to approach the end of a time step, in fractions of it.
#[derive(Clone, Copy, Debug)]
pub struct Stepping {
    /// First increment of the first time step.
    pub first: f64,
    /// Largest increment.
    pub largest: f64,
    /// Smallest increment before giving up.
    pub smallest: f64,
    /// Stopping rule at the end of a time step.
    pub newton: Newton,
}

/// One accepted load step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoadStep {
    /// Time t [s]; in a static scene the fraction of the
    /// full load.
    pub time: f64,
    /// Newton iterations.
    pub newton_iterations: usize,
    /// Norm of the unbalanced force [N].
    pub residual: f64,
    /// Residual wanted [N].
    pub residual_wanted: f64,
    /// Where the residual is larger than that because rounding allows no less:
    /// its estimated floor [N].
    pub rounding_floor: Option<f64>,
    /// Lower bound of J = det(I + ∇u) over all points of all elements.
    pub smallest_volume_ratio: f64,
    /// Displacement [m], three components per node.
    pub u: Vec<f64>,
    /// Multipliers of the chambers with a prescribed volume.
    pub multipliers: Vec<Multiplier>,
    /// The time step that it is in, if there is one; not in files, as [`Trajectory::step`](super::Trajectory::step) has it.
    #[serde(skip)]
    pub step: Option<Arc<TimeStep>>,
    /// Whether it is the end of a time step.
    pub ends_time_step: bool,
    /// What is known of it as a state of a path, if it is one.
    pub path: Option<Box<ArcPoint>>,
}

impl LoadStep {
    /// A certified state in which forces balance, by as many Newton iterations as are counted there.
    pub(crate) fn new(
        state: Configuration,
        balanced: Converged,
        smallest_volume_ratio: f64,
    ) -> Self {
        Self {
            time: state.time,
            newton_iterations: balanced.iterations,
            residual: balanced.residual,
            residual_wanted: balanced.wanted,
            rounding_floor: balanced.floor,
            smallest_volume_ratio,
            step: state.step.cloned(),
            u: state.u,
            multipliers: state.multipliers,
            ends_time_step: false,
            path: None,
        }
    }

    /// The state on a rest shape [m].
    pub fn iterate<'a>(&'a self, problem: &'a Problem, rest: &'a [Vec3]) -> Iterate<'a> {
        let (space, step) = (&problem.space, self.step.as_deref());
        let (u, multipliers) = (&self.u, &self.multipliers);
        Iterate { space, rest, u, time: self.time, multipliers, step, before: None }
    }

    /// The state alone.
    pub fn into_reached(self) -> Reached {
        let Self { time, u, multipliers, .. } = self;
        Reached { time, u, multipliers }
    }
}

/// No equilibrium at the end of a time step.
#[derive(Clone, Debug, thiserror::Error)]
#[error("no equilibrium beyond {:.1} % of the load: {failure}", 100.0 * time)]
pub struct Unreached {
    /// Last load that has an equilibrium.
    pub time: f64,
    /// What stopped the next step.
    pub failure: Failure,
    /// The states on both sides of it.
    pub attempt: Box<Attempt>,
}

/// A load step without an equilibrium.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The last equilibrium, or the rest shape [m].
    pub reached: Vec<f64>,
    /// The multipliers of prescribed volumes.
    pub multipliers: Vec<Multiplier>,
    /// The time step that fails.
    pub step: Arc<TimeStep>,
    /// Load that was tried.
    pub time: f64,
    /// The last iterate there [m].
    pub u: Vec<f64>,
    /// Residual of each iterate [N].
    pub residuals: Vec<f64>,
}

/// Solves under the full load from a nearby equilibrium, in one step. A factor
/// that the workspace still has is used, so that the result depends on it in its
/// last digits.
pub fn solve_from(
    problem: &Problem,
    workspace: &mut Workspace,
    start: &Configuration,
    newton: &Newton,
) -> Result<LoadStep, Failure> {
    workspace.indefinite_starts = 0;
    attempt(problem, workspace, start, start.time, newton).map_err(|failed| failed.failure)
}

/// Solves from the rest shape at t = 0 to the ends `times` of time steps without inertia, 1 alone for a static
/// scene: the load steps, of which the last is the end of the last time step.
pub fn solve(
    problem: &Problem,
    workspace: &mut Workspace,
    rest: &[Vec3],
    stepping: &Stepping,
    times: &[f64],
) -> Result<Vec<LoadStep>, Unreached> {
    let zero = vec![0.0; problem.dofs()];
    let start = State::new(zero.clone(), zero);
    let mut stepper = TimeStepper::new(*stepping, Integrator::new(Method::Quasistatic, start));
    let mut steps = Vec::new();
    for &end in times {
        stepper.advance(problem, workspace, rest, end, |step| steps.push(step.clone()))?;
    }
    Ok(steps)
}

pub(super) fn loosened(newton: &Newton) -> Newton {
    Newton {
        relative: LOOSE * newton.relative,
        absolute: LOOSE * newton.absolute,
        negligible: LOOSE * newton.negligible,
        ..*newton
    }
}

pub(crate) struct Failed {
    pub failure: Failure,
    pub u: Vec<f64>,
    pub residuals: Vec<f64>,
}

/// One load step to a load, from a state that surfaces can reach at an earlier one: the
/// supports are moved, or pulled where their straight path is blocked, the forces
/// balanced, prescribed volumes reached and the state certified.
pub(crate) fn attempt(
    problem: &Problem,
    workspace: &mut Workspace,
    start: &Configuration,
    time: f64,
    newton: &Newton,
) -> Result<LoadStep, Failed> {
    let before = start.iterate(problem);
    let mut state = Configuration { time, ..start.clone() };
    state.u = workspace.move_supports(problem, &Iterate { time, ..before });
    state.balanced_at = start.balanced_at.filter(|_| state.u == start.u);
    let free = workspace.max_step(problem, &before, &state.iterate(problem));
    let (mut residuals, mut pulling) = (Vec::new(), 0);
    if free < 1.0 {
        let around = pull_supports(problem, workspace, start, time, newton, &mut residuals);
        let Some(placed) = around else {
            let u = start.u.clone();
            return Err(Failed { failure: Failure::Blocked { free }, u, residuals });
        };
        (state.u, pulling) = (placed.u, placed.iterations);
    }
    let converged = match balance(problem, workspace, &mut state, newton, &mut residuals) {
        Ok(converged) => converged,
        Err(failure) => return Err(Failed { failure, u: state.u, residuals }),
    };
    let Converged { residual, wanted, floor, .. } = converged;
    if let Some(floor) = floor {
        let _told = workspace.notify(&Event::AtRoundingFloor { time, residual, wanted, floor });
    }
    match certify(problem, workspace, &state.iterate(problem)) {
        Ok(smallest_volume_ratio) => {
            let iterations = pulling + converged.iterations;
            let balanced = Converged { iterations, ..converged };
            Ok(LoadStep::new(state, balanced, smallest_volume_ratio))
        }
        Err(failure) => Err(Failed { failure, u: state.u, residuals }),
    }
}

/// A lower bound of J, if no energy objects and the body is nowhere turned inside out; where that is
/// tolerated, of its worst element.
pub(crate) fn certify(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
) -> Result<f64, Failure> {
    let clock = Clock::start();
    let certified = match certificate(at.space, at.rest, at.u) {
        Err(found) if problem.tolerates_inversion => Ok(found.volume_ratio()),
        certified => certified.map_err(Failure::from),
    };
    let certified = certified.and_then(|smallest| {
        problem.objection(at).map_or(Ok(smallest), |what| Err(Failure::Objection(what)))
    });
    workspace.timings.certificate += clock.elapsed();
    certified
}

/// Norm of the unbalanced force [N]; infinite where it is not defined.
pub(super) fn residual(problem: &Problem, workspace: &mut Workspace, at: &Iterate) -> f64 {
    let (gradient, _) = workspace.gradient(problem, at);
    let residual = norm(&problem.restrict(&gradient));
    if residual.is_nan() { f64::INFINITY } else { residual }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::FunctionSpace;
    use crate::energy::Energies;
    use crate::forward::Uncertified;
    use crate::material::{Lame, NeoHookean};

    /// A tetrahedron of edge ℓ = 1 cm. The middle of its edge 01 is moved by 0.26 ℓ towards corner 0,
    /// where J becomes 1 − 4 · 0.26; no quadrature point sees it. All is held but for one component
    /// of the middle of edge 23.
    fn pinched() -> (Problem, Vec<Vec3>) {
        let rest = vec![Vec3::zeros(), 0.01 * Vec3::x(), 0.01 * Vec3::y(), 0.01 * Vec3::z()];
        let space = FunctionSpace::new(2, 4, vec![[0, 1, 2, 3]]);
        let mut fixed = vec![true; 3 * space.node_count()];
        *fixed.last_mut().expect("ten nodes") = false;
        let mut u = vec![0.0; fixed.len()];
        u[3 * 4] = -0.0026;
        let energies = Energies::elastic(Box::new(NeoHookean(Lame::new(1e5, 0.35))));
        (Problem::new(space, energies, &fixed).with_displacement(&u), rest)
    }

    #[test]
    fn an_element_inside_out_is_refused_or_tolerated() {
        let newton = Newton {
            iterations: 30,
            relative: 1e-10,
            absolute: 1e-10,
            negligible: 0.0,
            ballooned: None,
        };
        let stepping = Stepping { first: 1.0, largest: 1.0, smallest: 0.5, newton };
        let (mut problem, rest) = pinched();
        let go = |problem: &Problem| {
            solve(problem, &mut Workspace::new(problem), &rest, &stepping, &[1.0])
        };
        let unreached = go(&problem).expect_err("refused");
        let inverted = Failure::Uncertified(Uncertified::Inverted {
            element: 0,
            at: Vec3::zeros(),
            value: -0.04,
        });
        assert_eq!(unreached.failure.to_string(), inverted.to_string());
        problem.tolerates_inversion = true;
        let steps = go(&problem).expect("tolerated");
        let found = steps.last().expect("one at least").smallest_volume_ratio;
        assert!((found + 0.04).abs() < 1e-12, "{found}");
    }
}
