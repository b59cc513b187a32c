//! Newton's method with a line search on the potential energy.
//!
//! H δ = −g, with H the exact Hessian while it is positive definite; else with
//! the elastic tangents projected; else with a multiple of the identity added
//! until it is (Hessian modification). As long as it converges, the system is solved
//! by conjugate gradients with an earlier factor as preconditioner, to an accuracy that
//! keeps convergence superlinear (inexact Newton: Dembo, Eisenstat and Steihaug 1982,
//! doi:10.1137/0719025).
//!
//! **The end at the rounding floor.** More iterations cannot help when the predicted
//! decrease of the energy is below [`ENERGY_ROUNDING`] of it, and in addition the residual has not
//! halved for [`STALLED_ITERATIONS`] iterations or no iteration is left; or when there is no step at all.
//! The best state is then accepted if its residual is at most
//! [`Workspace::rounding_floor`], and [`Converged::floor`] is that floor; else the
//! result is [`Failure::Stagnated`]. The floor is
//! a bound: residuals of cubes, bars, beam and gripper ended at 0.06 to 0.11 of it.
//!
//! Source: Nocedal and Wright, "Numerical Optimization", chapters 3 and 6.

use super::ballooning::{Ballooning, End};
use super::hessian_modification::{Modification, Point, direction};
use super::line_search::{Accepted, line_search};
use super::watch::Event;
use super::{Configuration, Failure, Problem, Workspace};
use crate::energy::Iterate;
use crate::math::linear::{dot, norm};

/// Relative accuracy of inexact steps, at most and at least.
const FORCING: (f64, f64) = (1e-2, 1e-6);
/// Residual that the linear system may leave, relative to the wanted one. With 0.1 a Taylor test of a wound chamber met it.
const LINEAR_RESIDUAL: f64 = 0.01;
/// Iterations without a residual of half the smallest before.
const STALLED_ITERATIONS: usize = 3;
/// Ratio of residuals that tells one stage of the iteration from another.
const STAGE_RATIO: f64 = 10.0;
/// Steps with a modified Hessian before the exact one is tried again.
const MODIFIED_STEPS: usize = 8;
/// How many times as large as a negligible residual the forces must have been.
const PREVAILING_FORCES: f64 = 1e6;
/// Predicted decrease of the energy, relative to it, that is within rounding.
const ENERGY_ROUNDING: f64 = 1e-12;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Newton {
    /// Largest number of iterations.
    pub iterations: usize,
    /// Residual relative to the forces that balance.
    pub relative: f64,
    /// Residual below which any state counts as an equilibrium [N].
    pub absolute: f64,
    /// Residual that suffices where forces of `PREVAILING_FORCES` times as much were to balance [N].
    pub negligible: f64,
    /// The search ends with [`Failure::Balloons`] when a chamber that softens as it grows has this many times its volume
    /// at the start; never if there is no number. A state to which such a chamber would snap is then not found.
    pub ballooned: Option<f64>,
}

/// An equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converged {
    /// Iterations made.
    pub iterations: usize,
    /// Norm of the unbalanced force [N].
    pub residual: f64,
    /// Residual wanted [N].
    pub wanted: f64,
    /// Where the residual is larger than wanted and rounding allows no less:
    /// its estimated floor [N].
    pub floor: Option<f64>,
    /// The largest scale of the forces on the way [N].
    pub peak: f64,
}

/// One iterate.
#[derive(Clone)]
struct State {
    u: Vec<f64>,
    energy: f64,
    gradient: Vec<f64>,
    /// Scale of the forces [N].
    scale: f64,
    residual: f64,
}

impl Newton {
    /// Moves the displacement to an equilibrium.
    pub fn solve(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        state: &mut Configuration,
    ) -> Result<Converged, Failure> {
        self.trace(problem, workspace, state, &mut Vec::new())
    }

    /// Moves the displacement to an equilibrium, and adds the residual of every iterate [N] to
    /// `residuals`.
    pub fn trace(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        state: &mut Configuration,
        residuals: &mut Vec<f64>,
    ) -> Result<Converged, Failure> {
        let at = state.iterate(problem);
        let energy = workspace.value(problem, &at);
        if !energy.is_finite() {
            return Err(Failure::Inadmissible);
        }
        let first = Accepted { u: state.u.clone(), energy, gradient: None };
        let now = reached(problem, workspace, &at, first);
        let mut search = Search::new(self, problem, workspace, &at, now);
        let result = search.run(residuals);
        state.u = search.now.u;
        result
    }

    /// Residual of an equilibrium [N] where forces of a scale balance, and of `peak` at most were to.
    /// Without loads only the residual itself is left to compare with, so that the past counts.
    pub(crate) fn wanted(&self, scale: f64, peak: f64) -> f64 {
        let negligible = self.negligible.min(peak / PREVAILING_FORCES);
        (self.relative * scale).max(self.absolute).max(negligible)
    }
}

/// A search of an equilibrium: the state of Newton's method between two iterations.
struct Search<'a> {
    newton: &'a Newton,
    problem: &'a Problem,
    workspace: &'a mut Workspace,
    /// All of an iterate but its displacement.
    at: Iterate<'a>,
    now: State,
    flat: Flat,
    indefinite: Indefinite,
    ballooning: Option<Ballooning>,
    /// Iterations made.
    iterations: usize,
    /// The largest scale of the forces so far [N].
    peak: f64,
    /// Residual before the last step [N].
    before: f64,
    /// Whether the last step was within rounding.
    within_rounding: bool,
}

impl<'a> Search<'a> {
    fn new(
        newton: &'a Newton,
        problem: &'a Problem,
        workspace: &'a mut Workspace,
        at: &Iterate<'a>,
        now: State,
    ) -> Self {
        let start = Iterate { u: &now.u, ..*at };
        Self {
            newton,
            problem,
            at: *at,
            flat: Flat { best: now.clone(), mark: f64::INFINITY, iterations: 0 },
            indefinite: Indefinite::expected(workspace.indefinite_starts > 0),
            ballooning: newton.ballooned.map(|times| Ballooning::from(problem, &start, times)),
            workspace,
            now,
            iterations: 0,
            peak: 0.0,
            before: f64::INFINITY,
            within_rounding: false,
        }
    }

    /// Iterates to an equilibrium, and adds the residual of every iterate [N] to `residuals`.
    fn run(&mut self, residuals: &mut Vec<f64>) -> Result<Converged, Failure> {
        loop {
            self.peak = self.peak.max(self.now.scale);
            let wanted = self.newton.wanted(self.now.scale, self.peak);
            if let Some(converged) = self.look(residuals, wanted)? {
                return Ok(converged);
            }
            if let Some(converged) = self.step(wanted)? {
                return Ok(converged);
            }
            self.iterations += 1;
        }
    }

    /// Judges the iterate: an equilibrium, if it is one.
    fn look(
        &mut self,
        residuals: &mut Vec<f64>,
        wanted: f64,
    ) -> Result<Option<Converged>, Failure> {
        let (iteration, residual) = (self.iterations, self.now.residual);
        let energy = self.now.energy;
        log::debug!("newton {iteration}  |g| {residual:.2e} N  energy {energy:.9e} J");
        let event = Event::Iterate { time: self.at.time, iteration, residual, wanted };
        if self.workspace.notify(&event).is_break() {
            return Err(Failure::Interrupted);
        }
        residuals.push(residual);
        // an infinite one is within a tolerance that is infinite
        if !residual.is_finite() {
            return Err(Failure::Inadmissible);
        }
        if residual <= wanted {
            return Ok(Some(self.converged(residual, wanted, None)));
        }
        self.flat.watch(&self.now);
        if self.iterations < self.newton.iterations {
            return Ok(None);
        }
        if self.within_rounding {
            return self.end_at_best().map(Some);
        }
        Err(Failure::IterationLimit { iterations: self.iterations, residual, wanted })
    }

    /// Makes a step, or ends at the best state where there is none and rounding allows no less.
    fn step(&mut self, wanted: f64) -> Result<Option<Converged>, Failure> {
        let residual = self.now.residual;
        // no more accurate than the tolerance needs
        let enough = (LINEAR_RESIDUAL * wanted / residual).clamp(FORCING.1, FORCING.0);
        let forcing = (residual / self.before).powi(2).clamp(enough, FORCING.0);
        self.before = residual;
        let from = self.indefinite.modification(residual);
        let (step, by, decrease) = self.descend(forcing, from);
        self.indefinite.watch(residual, from, by);
        // a step that was halved until nothing moves is none
        let step = step.filter(|accepted| accepted.u != self.now.u);
        if self.iterations == 0 {
            let starts = &mut self.workspace.indefinite_starts;
            *starts = match (from, by) {
                (Modification::Projected, _) => starts.saturating_sub(1),
                (_, by) if by < Modification::Projected => 0,
                _ => MODIFIED_STEPS,
            };
        }
        self.within_rounding = decrease <= ENERGY_ROUNDING * self.now.energy.abs();
        let stalled = step.is_none() || self.flat.iterations >= STALLED_ITERATIONS;
        if self.within_rounding && stalled {
            return self.end_at_best().map(Some);
        }
        let Some(accepted) = step else {
            // energies that cancel each other have more rounding than their sum shows
            let iterations = self.iterations;
            let floor = self.at_floor();
            let converged = floor.map_err(|_| Failure::Stalled { iterations, residual, wanted })?;
            self.now = self.flat.best.clone();
            return Ok(Some(converged));
        };
        self.accept(accepted).map(|()| None)
    }

    /// A step that decreases the energy, by the first modification of the Hessian that
    /// gives one from `from` on, the last modification tried, and the decrease that the first
    /// direction predicts [J].
    fn descend(
        &mut self,
        forcing: f64,
        from: Modification,
    ) -> (Option<Accepted>, Modification, f64) {
        let Self { problem, workspace, at, now, .. } = self;
        let point = Point { at: Iterate { u: &now.u, ..*at }, gradient: &now.gradient };
        let (mut by, mut from) = (from, Some(from));
        let mut predicted = f64::INFINITY;
        while let Some(modification) = from {
            let found = direction(problem, workspace, &point, modification, forcing);
            let Some((modification, direction)) = found else { break };
            by = modification;
            let slope = dot(point.gradient, &direction);
            predicted = predicted.min(0.5 * slope.abs());
            if slope < 0.0
                && let Some(accepted) =
                    line_search(problem, workspace, &point, now.energy, &direction)
            {
                log::debug!("{modification:?} step");
                return (Some(accepted), by, predicted);
            }
            log::debug!("no {modification:?} step");
            // other directions have no digits to compare either
            from = modification.next().filter(|_| predicted > ENERGY_ROUNDING * now.energy.abs());
        }
        (None, by, predicted)
    }

    /// Moves on to the next iterate.
    fn accept(&mut self, accepted: Accepted) -> Result<(), Failure> {
        let next = reached(self.problem, self.workspace, &self.at, accepted);
        let before = std::mem::replace(&mut self.now, next);
        let Some(ballooning) = &mut self.ballooning else { return Ok(()) };
        let ends = [&before, &self.now].map(|end| End { u: &end.u, gradient: &end.gradient });
        match ballooning.watch(self.problem, &self.at, ends) {
            Some([start, volume]) => {
                let iterations = self.iterations + 1;
                Err(Failure::Balloons { iterations, start, volume })
            }
            None => Ok(()),
        }
    }

    fn converged(&self, residual: f64, wanted: f64, floor: Option<f64>) -> Converged {
        let Self { iterations, peak, .. } = *self;
        Converged { iterations, residual, wanted, floor, peak }
    }

    /// Goes back to the best state, an equilibrium if its residual is as small as rounding allows.
    fn end_at_best(&mut self) -> Result<Converged, Failure> {
        self.now = self.flat.best.clone();
        self.at_floor()
    }

    /// Whether the residual of the best state, which falls no further, is as small as rounding allows.
    fn at_floor(&mut self) -> Result<Converged, Failure> {
        let State { u, residual, scale, .. } = &self.flat.best;
        let (residual, scale) = (*residual, *scale);
        let wanted = self.newton.wanted(scale, self.peak);
        let floor = self.workspace.rounding_floor(self.problem, &Iterate { u, ..self.at });
        log::debug!("residual {residual:.2e} N does not fall; floor by rounding {floor:.1e} N");
        if residual <= floor {
            return Ok(self.converged(residual, wanted, Some(floor)));
        }
        let iterations = self.iterations;
        Err(Failure::Stagnated { iterations, residual, wanted, floor, scale })
    }
}

/// The state with the smallest residual, and for how long none was half as large.
struct Flat {
    best: State,
    mark: f64,
    iterations: usize,
}

impl Flat {
    fn watch(&mut self, now: &State) {
        if now.residual < 0.5 * self.mark {
            (self.mark, self.iterations) = (now.residual, 0);
        } else {
            self.iterations += 1;
        }
        if now.residual < self.best.residual {
            self.best.clone_from(now);
        }
    }
}

/// Foresees where the exact Hessian is not positive definite, so that it is neither made
/// nor factored there in vain.
///
/// A residual that has grown a lot although the energy fell means crushed elements or a
/// new contact. After a step with a modified Hessian, the next one is of the same kind
/// until the residual has fallen a lot, or for [`MODIFIED_STEPS`] steps. Where the method began with
/// an indefinite Hessian, it is taken to do so the next [`MODIFIED_STEPS`] times, too
/// ([`Workspace::indefinite_starts`]): loads grow from one time step to the next.
///
/// What it gave (Newton iterations / factorisations, of which failed; before and with it,
/// and with the pressure's stiffness left out of the projected Hessian): frog P2 at
/// 55 kPa from rest 15/14, 5 and 13/9, 1; worm in motion, 5 steps, 36/23, 6 and 36/16, 0.
struct Indefinite {
    /// Whether the first Hessian is taken to be indefinite.
    expected: bool,
    /// The least residual so far [N].
    least: f64,
    /// Residual where the Hessian was last found to be indefinite [N].
    found: f64,
    /// Steps since.
    steps: usize,
}

impl Indefinite {
    /// At the start, where the Hessian may be expected to be indefinite.
    fn expected(expected: bool) -> Self {
        Self { expected, least: f64::INFINITY, found: f64::INFINITY, steps: 0 }
    }

    /// The modification to begin with.
    fn modification(&mut self, residual: f64) -> Modification {
        self.least = self.least.min(residual);
        let lasts = self.steps < MODIFIED_STEPS && residual * STAGE_RATIO > self.found;
        if lasts {
            return Modification::Projected;
        }
        if std::mem::take(&mut self.expected) || residual > STAGE_RATIO * self.least {
            (self.found, self.steps) = (residual, 0);
            return Modification::Projected;
        }
        Modification::Near
    }

    /// Takes note of the modification that a step began with, and of the one it took.
    fn watch(&mut self, residual: f64, from: Modification, by: Modification) {
        if by < Modification::Projected {
            self.found = f64::INFINITY;
        } else if from < Modification::Projected {
            (self.found, self.steps) = (residual, 0);
        } else {
            self.steps += 1;
        }
    }
}

fn reached(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    accepted: Accepted,
) -> State {
    let Accepted { u, energy, gradient } = accepted;
    let (gradient, scale) =
        gradient.unwrap_or_else(|| workspace.gradient(problem, &Iterate { u: &u, ..*at }));
    let residual = norm(&problem.restrict(&gradient));
    State { u, energy, gradient, scale, residual }
}
