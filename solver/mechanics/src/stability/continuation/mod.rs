//! Equilibrium paths through limit points, by arc length.
//!
//! Where the load of a static scene has a maximum, as the pressure of a balloon has, no load beyond it can be
//! prescribed. A path goes on: the load t is an unknown like the displacement u and the pressures P̂ of prescribed
//! volumes, and the next state lies on a sphere around the last one,
//!
//! R(u, P̂, t) = 0,   V(u) = V*(t),   |Δu|²/ℓ² + Δt² = Δs²
//!
//! found by Newton's method with the exact tangent of all of it, from a predictor along the tangent of the path and its
//! change since the state before. ℓ is |du/dt| at rest, so that both parts count alike there. Δs follows the number of
//! iterations. It is halved where the direction of the path would turn by much, and where a stable path would pass a
//! bifurcation: another branch may be near. Surfaces stay apart as in every load step, and every state is certified.
//!
//! Between two states the number of negative eigenvalues changes by one where the load turns (a limit point); by
//! anything else other branches leave (a bifurcation).
//!
//! Source: Riks 1979, "An incremental approach to the solution of snapping and buckling problems",
//! doi:10.1016/0020-7683(79)90081-7; Crisfield 1981, doi:10.1016/0045-7949(81)90108-5; consistent linearisation:
//! Ramm 1981; orientation by the last direction: Keller 1977.

mod corrector;
mod direction;
mod limit_point;
#[cfg(test)]
pub(super) mod tests;

use std::sync::Arc;

use mesh::Vec3;
use serde::{Deserialize, Serialize};

use self::corrector::{Corrector, Ends};
use self::direction::Direction;
use super::spectrum::{negative_eigenvalues, softest};
use super::tangent_system::{
    LoadRate, Residual, Row, at_held_load, extent, factor, path_direction, with_supports,
};
use crate::energy::{Iterate, TimeStep};
use crate::forward::{
    ArcPoint, Configuration, Converged, Failed, Failure, LoadStep, Problem, Reached, SingularPoint,
    Singularity, Stability, TimeStepper, Unreached, Workspace, certify,
};
use crate::math::linear::norm;

/// Fraction of the free path of surfaces that a predictor goes.
const NEARLY: f64 = 0.9;
/// Arc length, in first ones, below which surfaces that meet leave no way: a barrier would have moved them apart.
const FOLDED: f64 = 1e-6;
/// Newton iterations that the arc length aims at.
const AIM: f64 = 5.0;
/// Largest growth of the arc length from one state to the next.
const GROWTH: f64 = 1.6;
/// Cosine between directions of successive states, at least.
const STRAIGHT: f64 = 0.5;
/// Cosine above which the arc length may grow.
const NEARLY_STRAIGHT: f64 = 0.95;
/// How far from the last state the next may be, in arc lengths.
const REACH: f64 = 2.0;
/// Arc length, in first ones, above which a path that is stable passes no bifurcation: next to one the path of a body
/// that is not quite symmetrical turns by much, and a long arc would lead to a branch that does not hang together with
/// it.
const ACROSS: f64 = 1.0 / 16.0;
/// Loads between 0 and 1 at which it is asked whether anything depends on the load.
const LOADS: usize = 8;

/// How to follow a path.
#[derive(Clone, Copy, Debug)]
pub struct ArcLength {
    /// First increment of the load.
    pub first: f64,
    /// Largest arc length, in loads: that of an increment of the load at rest.
    pub largest: f64,
    /// Smallest arc length before giving up, as a fraction of the first.
    pub smallest: f64,
    /// The load at which it ends: 1, beyond which the loads of a scene are not defined, or more where they are.
    pub end: f64,
}

/// All that determines the next state of a path, beside the last one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ArcProgress {
    /// The direction of the path at the last state, of length 1 ...
    direction: Direction,
    /// ... and its change with the arc length before it, if there was a state before.
    turning: Option<Direction>,
    /// ℓ [m].
    scale: f64,
    /// Next arc length Δs.
    length: f64,
    /// The first arc length.
    first: f64,
    /// Negative eigenvalues at the last state.
    negative: usize,
    /// The softest stiffness at rest [N/m].
    rest_stiffness: f64,
    /// Arc length from rest to the last state.
    arc: f64,
}

/// Follows the path of a static scene from rest, state by state.
pub struct Continuation {
    /// How.
    pub path: ArcLength,
    /// Where it is; none before the first state.
    pub progress: Option<ArcProgress>,
    /// Where it was at the state before, with the arc length that led to the last one.
    before: Option<ArcProgress>,
}

/// A state that was found, with what it makes of the progress.
struct Found {
    step: LoadStep,
    progress: ArcProgress,
}

impl Continuation {
    /// Begins at rest.
    pub fn new(path: ArcLength) -> Self {
        Self { path, progress: None, before: None }
    }

    /// The next state. It ends the time step where the load reaches its end from below.
    pub fn next(
        &mut self,
        stepper: &mut TimeStepper,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
    ) -> Result<LoadStep, Unreached> {
        let step = stepper.begun(problem, workspace, rest, 1.0);
        let mut progress = match self.progress.take() {
            Some(progress) => progress,
            None => {
                let at = Iterate { step: Some(&step), ..stepper.iterate(problem, rest) };
                begun(problem, workspace, &at, self.path.first).map_err(|failure| {
                    let failed = Failed { failure, u: at.u.to_vec(), residuals: Vec::new() };
                    stepper.unreached(problem, rest, failed, at.time)
                })?
            }
        };
        loop {
            let last = Iterate { step: Some(&step), ..stepper.iterate(problem, rest) };
            let end = self.path.end;
            let from = ArcStep { problem, last, step: &step, progress: &progress, end };
            let failed = match self.attempt(&from, stepper, workspace) {
                Ok(Found { step, progress: next }) => {
                    (self.before, self.progress) = (Some(progress), Some(next));
                    return Ok(stepper.accept(step, 0.5, problem, workspace, rest));
                }
                Err(failed) => failed,
            };
            stepper.progress.newton_iterations += failed.residuals.len().saturating_sub(1);
            let interrupted = matches!(failed.failure, Failure::Interrupted);
            log::debug!("arc length {:.2e} failed ({})", progress.length, failed.failure);
            progress.length *= 0.5;
            if interrupted || progress.length < self.path.smallest * progress.first {
                self.progress = Some(progress);
                return Err(stepper.unreached(problem, rest, failed, stepper.progress.time()));
            }
        }
    }

    /// One state from the last.
    fn attempt(
        &self,
        from: &ArcStep,
        stepper: &TimeStepper,
        workspace: &mut Workspace,
    ) -> Result<Found, Failed> {
        let mut residuals = Vec::new();
        let predicted = from.predict(workspace).map_err(|failure| {
            let u = from.last.u.to_vec();
            Failed { failure, u, residuals: Vec::new() }
        });
        let Predicted { mut state, length, ends } = predicted?;
        let newton = &stepper.stepping.newton;
        let mut correct = |state: &mut Configuration, ends| {
            let corrector = Corrector { from, newton, ends };
            corrector.correct(workspace, state, &mut residuals)
        };
        let start = state.clone();
        let mut balanced = correct(&mut state, ends);
        if matches!(balanced, Ok(None)) {
            state = from.at_full_load(start);
            balanced = correct(&mut state, Ends::AtFullLoad);
        }
        let first = from.progress.first;
        let limits = Lengths {
            longest: self.path.largest / self.path.first * first,
            across: ACROSS.max(2.0 * self.path.smallest) * first,
        };
        let balanced = balanced.and_then(|found| found.ok_or(Failure::Singular));
        let found = balanced.and_then(|by| from.finish(workspace, &state, by, length, &limits));
        found.map_err(|failure| Failed { failure, u: state.u, residuals })
    }
}

/// Arc lengths that are not exceeded.
struct Lengths {
    /// Anywhere.
    longest: f64,
    /// Across a bifurcation.
    across: f64,
}

/// A step along the path, from the last state to the next.
struct ArcStep<'a> {
    problem: &'a Problem,
    last: Iterate<'a>,
    step: &'a Arc<TimeStep>,
    progress: &'a ArcProgress,
    /// The full load.
    end: f64,
}

/// Where a corrector begins.
struct Predicted<'a> {
    state: Configuration<'a>,
    /// Δs
    length: f64,
    ends: Ends,
}

impl<'a> ArcStep<'a> {
    /// A state along the direction of the path, as far as surfaces are free.
    fn predict(&self, workspace: &mut Workspace) -> Result<Predicted<'a>, Failure> {
        let ArcProgress { direction, length, .. } = self.progress;
        let to_full_load = (self.end - self.last.time) / direction.load;
        let reaches = direction.load > 0.0 && to_full_load <= *length;
        let length = if reaches { to_full_load } else { *length };
        let state = self.moved(length);
        let free = workspace.max_step(self.problem, &self.last, &state.iterate(self.problem));
        if free < 1.0 {
            let length = NEARLY * free * length;
            if length <= FOLDED * self.progress.first {
                return Err(Failure::Folded);
            }
            let state = self.moved(length);
            return Ok(Predicted { state, length, ends: Ends::OnSphere(length) });
        }
        if reaches {
            let state = self.at_full_load(state);
            return Ok(Predicted { state, length, ends: Ends::AtFullLoad });
        }
        Ok(Predicted { state, length, ends: Ends::OnSphere(length) })
    }

    /// The last state, moved along the path as far as its direction and its curvature tell.
    fn moved(&self, length: f64) -> Configuration<'a> {
        let ArcProgress { direction, turning, .. } = self.progress;
        let mut change = direction.scaled(length);
        if let Some(turning) = turning {
            change = change.plus(&turning.scaled(0.5 * length * length));
        }
        let Direction { u: along, pressures, load } = &change;
        let time = self.last.time + load;
        let mut u = with_supports(self.problem, self.last.u, time);
        u.iter_mut().zip(self.problem.prolong(along)).for_each(|(u, d)| *u += d);
        let mut multipliers = self.last.multipliers.to_vec();
        multipliers.iter_mut().zip(pressures).for_each(|(m, p)| m.pressure += p);
        Configuration {
            rest: self.last.rest,
            time,
            step: Some(self.step),
            u,
            multipliers,
            balanced_at: None,
        }
    }

    /// A state with the full load on it.
    fn at_full_load(&self, state: Configuration<'a>) -> Configuration<'a> {
        let u = with_supports(self.problem, &state.u, self.end);
        Configuration { time: self.end, u, ..state }
    }

    /// What a state is away from the last one.
    fn change(&self, state: &Iterate) -> Direction {
        let u: Vec<f64> = state.u.iter().zip(self.last.u).map(|(a, b)| a - b).collect();
        let pressures = state.multipliers.iter().zip(self.last.multipliers);
        Direction {
            u: self.problem.dirichlet.unknowns(&u),
            pressures: pressures.map(|(a, b)| a.pressure - b.pressure).collect(),
            load: state.time - self.last.time,
        }
    }

    /// A balanced state with its certificate, its stability and where the path goes from it.
    fn finish(
        &self,
        workspace: &mut Workspace,
        state: &Configuration,
        balanced: Converged,
        length: f64,
        limits: &Lengths,
    ) -> Result<Found, Failure> {
        let problem = self.problem;
        let at = state.iterate(problem);
        let smallest_volume_ratio = certify(problem, workspace, &at)?;
        let moved = self.change(&at).length(self.progress.scale);
        let (direction, stability) = self.direction_at(workspace, &at).ok_or(Failure::Singular)?;
        let cosine = direction.product(&self.progress.direction, self.progress.scale);
        let strayed = Failure::Strayed { degrees: cosine.clamp(-1.0, 1.0).acos().to_degrees() };
        if cosine < STRAIGHT || moved > REACH * length {
            return Err(strayed);
        }
        let negative = stability.negative;
        let point = self.point(stability, &direction, moved, state.time);
        let bifurcates = point.passed.iter().any(|p| p.kind == Singularity::Bifurcation);
        if bifurcates && self.progress.negative == 0 && length > limits.across {
            return Err(strayed);
        }
        let eased = (AIM / balanced.iterations.max(1) as f64).sqrt().clamp(0.5, GROWTH);
        let grown = if cosine < NEARLY_STRAIGHT { eased.min(1.0) } else { eased };
        let turning = direction.plus(&self.progress.direction.scaled(-1.0)).scaled(1.0 / moved);
        // the arc length that the step made, which one to the full load may have cut
        let made = length.max(moved.min(self.progress.length));
        let progress = ArcProgress {
            turning: Some(turning),
            negative,
            arc: point.arc,
            length: (grown * made).min(limits.longest),
            direction,
            ..self.progress.clone()
        };
        let (ends_time_step, path) = (state.time >= self.end, Some(Box::new(point)));
        let step = LoadStep::new(state.clone(), balanced, smallest_volume_ratio);
        let step = LoadStep { ends_time_step, path, ..step };
        Ok(Found { step, progress })
    }

    /// The direction of the path at a state, and its stability; none where the tangent is singular.
    fn direction_at(
        &self,
        workspace: &mut Workspace,
        at: &Iterate,
    ) -> Option<(Direction, Stability)> {
        let ArcProgress { direction: last, scale, .. } = self.progress;
        let constraints = self.problem.constraints(at);
        let rate = LoadRate::of(self.problem, workspace, at);
        let factor = factor(self.problem, workspace, at)?;
        let (u, mut rest) =
            path_direction(self.problem, factor, &constraints, &rate, last.row(*scale))?;
        let load = rest.pop()?;
        let direction = Direction { u, pressures: rest, load }.unit(*scale)?;
        let held = at_held_load(self.problem, factor, &constraints);
        let stability = Stability::with(self.problem, factor, &held, &direction.u)?;
        Some((direction, stability))
    }

    /// What is known of a state on the path.
    fn point(
        &self,
        stability: Stability,
        direction: &Direction,
        moved: f64,
        load: f64,
    ) -> ArcPoint {
        let ArcProgress { negative: before, arc, rest_stiffness, direction: last, .. } =
            self.progress;
        let turned = (last.load > 0.0) != (direction.load > 0.0);
        let changed = stability.negative.abs_diff(*before);
        ArcPoint {
            arc: arc + moved,
            load_rate: direction.load,
            stability,
            rest_stiffness: *rest_stiffness,
            passed: passed([self.last.time, load], turned, changed),
        }
    }
}

/// What lies between two loads where the load has turned or not, and the number of negative eigenvalues has changed.
fn passed(loads: [f64; 2], turned: bool, changed: usize) -> Vec<SingularPoint> {
    let point = |kind| SingularPoint { kind, loads };
    let limit = turned.then(|| point(Singularity::LimitPoint));
    let left = changed.abs_diff(usize::from(turned));
    let branches = (left > 0).then(|| point(Singularity::Bifurcation));
    limit.into_iter().chain(branches).collect()
}

/// The direction of the path at rest, towards more load, and a first arc length.
fn begun(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    first: f64,
) -> Result<ArcProgress, Failure> {
    let constraints = problem.constraints(at);
    let rate = LoadRate::of(problem, workspace, at);
    if rate.vanishes() && !is_loaded(problem, workspace, at) {
        return Err(Failure::NoLoad);
    }
    let factor = factor(problem, workspace, at).ok_or(Failure::Inadmissible)?;
    let row = Row { u: vec![0.0; rate.force.len()], load: 1.0 };
    let direction = path_direction(problem, factor, &constraints, &rate, row);
    let (u, mut rest) = direction.ok_or(Failure::Singular)?;
    let load = rest.pop().ok_or(Failure::Singular)?;
    let held = at_held_load(problem, factor, &constraints);
    let (rest_stiffness, _) = softest(factor, &held).ok_or(Failure::Singular)?;
    let negative = negative_eigenvalues(factor, &held);
    let scale = match norm(&u) {
        0.0 => size(problem, at),
        length => length,
    };
    let direction = Direction { u, pressures: rest, load };
    let length = first * direction.length(scale);
    let direction = direction.unit(scale).ok_or(Failure::Singular)?;
    let (first, arc) = (length, 0.0);
    let turning = None;
    Ok(ArcProgress { direction, turning, scale, length, first, negative, rest_stiffness, arc })
}

/// Whether any load up to the full one moves the body or a volume.
fn is_loaded(problem: &Problem, workspace: &mut Workspace, at: &Iterate) -> bool {
    (1..=LOADS).any(|i| {
        let time = i as f64 / LOADS as f64;
        let u = with_supports(problem, at.u, time);
        let loaded = Residual::of(problem, workspace, &Iterate { u: &u, time, ..*at });
        loaded.norm() > 0.0 || loaded.gaps().iter().any(|gap| *gap != 0.0)
    })
}

/// A displacement of all nodes by a tenth of the body [m], in the norm of the unknowns.
fn size(problem: &Problem, at: &Iterate) -> f64 {
    0.1 * extent(at) * (problem.dirichlet.free().len() as f64).sqrt()
}
