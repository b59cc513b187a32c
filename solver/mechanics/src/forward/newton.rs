//! Newton's method with a line search on the potential energy.
//!
//! H δ = −g, with H the exact Hessian while it is positive definite; else with
//! the elastic tangents projected; else with a multiple of the identity added
//! until it is (Hessian modification). As long as it converges, the system is solved
//! by conjugate gradients with an earlier factor as preconditioner, to an accuracy that
//! keeps convergence superlinear (inexact Newton: Dembo, Eisenstat and Steihaug 1982,
//! doi:10.1137/0719025).
//!
//! **Foreseen pressures.** A step turns parts of a body, and leaves changes of volume of second order. Where the bulk
//! modulus is large they have large pressures, which are none of those of the equilibrium: the exact Hessian with them is
//! often indefinite, and its next step bad. So ∂²J/∂F² has the pressure that was foreseen at the start of the step,
//! p₀ + ∂p₀/∂J cof F₀ : ΔF ([`Iterate::before`]), while the residual is as it is: the same as Newton's method with
//! independent pressures that are eliminated. Equilibria do not change, and convergence stays quadratic. Steps may
//! increase the energy for a while (`excursion`), but not beside fibres and threads: these have large forces of second
//! order, too. To foresee those of threads gave 180 iterations for 186.
//!
//! **Tangents.** The first step from an equilibrium at another load is made with the exact Hessian at that load. It is
//! positive definite where the equilibrium is stable; at the new load it is often not.
//!
//! Iterations of the finger of `cad2fem new` in its first three load steps: 15, 17, 18 without all this, 5, 7, 7 with
//! foreseen pressures and excursions, 4, 4, 4 with tangents, too.
//!
//! **The end at the rounding floor.** More iterations cannot help when the predicted
//! decrease of the energy is below [`ENERGY_ROUNDING`] of it, and in addition the residual has not
//! halved for [`STALLED_ITERATIONS`] iterations or no iteration is left; or when there is no step at all.
//! The best state is then accepted if its residual is at most
//! [`Workspace::rounding_floor`], and [`Converged::floor`] is that floor; else the
//! result is [`Failure::Stagnated`]. The floor is
//! a bound: residuals of cubes, bars, beam and gripper ended at 0.06 to 0.11 of it.
//!
//! Source: Nocedal and Wright, "Numerical Optimization", chapters 3 and 6; of stresses as unknowns in Newton's method
//! alone Magisano, Leonetti and Garcea 2017, "How to improve efficiency and robustness of the Newton method in
//! geometrically non-linear structural problem discretized via displacement-based finite elements".

use super::ballooning::{Ballooning, End};
use super::evaluated::Evaluated;
use super::excursion::Excursion;
use super::hessian_modification::{Modification, Point, direction};
use super::indefinite::Indefinite;
use super::line_search::{Accepted, line_search};
use super::watch::Event;
use super::{Configuration, Failure, Problem, Workspace};
use crate::energy::Iterate;
use crate::math::linear::dot;

/// Relative accuracy of inexact steps, at most and at least.
const FORCING: (f64, f64) = (1e-2, 1e-6);
/// The same while the energy is larger than it was. A PneuNet took 116 iterations with 1e-2 and 98 with 1e-4.
const OUT: f64 = 1e-5;
/// Residual that the linear system may leave, relative to the wanted one. With 0.1 a Taylor test of a wound chamber met it.
const LINEAR_RESIDUAL: f64 = 0.01;
/// Iterations without a residual of half the smallest before.
const STALLED_ITERATIONS: usize = 3;
/// Solutions that begin with a modified Hessian after one whose exact one was indefinite at its start.
const INDEFINITE_STARTS: usize = 8;
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
        let u = state.u.clone();
        let first = Accepted { u, energy, gradient: None, decreases: true, is_long: true };
        let now = Evaluated::of(first, problem, workspace, &at);
        let tangent_at = state.balanced_at.filter(|time| *time != state.time);
        let mut search = Search::new(self, problem, workspace, &at, now, tangent_at);
        let result = search.run(residuals);
        (state.u, state.balanced_at) = (search.now.u, None);
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
    now: Evaluated,
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
    /// The displacement that the last step began at [m].
    last: Option<Vec<f64>>,
    /// Where the energy has grown since.
    excursion: Excursion,
    /// The time of the load for the first Hessian, if it is not that of the search [s].
    tangent_at: Option<f64>,
}

impl<'a> Search<'a> {
    fn new(
        newton: &'a Newton,
        problem: &'a Problem,
        workspace: &'a mut Workspace,
        at: &Iterate<'a>,
        now: Evaluated,
        tangent_at: Option<f64>,
    ) -> Self {
        let start = Iterate { u: &now.u, ..*at };
        let is_reinforced = problem.energies.terms().any(|term| term.energy.is_reinforcement());
        let is_expected = workspace.indefinite_starts > 0 && tangent_at.is_none();
        Self {
            newton,
            problem,
            at: *at,
            flat: Flat { best: now.clone(), mark: f64::INFINITY, iterations: 0 },
            indefinite: Indefinite::new(is_expected, tangent_at.is_some()),
            ballooning: newton.ballooned.map(|times| Ballooning::from(problem, &start, times)),
            workspace,
            now,
            iterations: 0,
            peak: 0.0,
            before: f64::INFINITY,
            within_rounding: false,
            last: None,
            excursion: Excursion::new(!is_reinforced),
            tangent_at,
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
        if self.excursion.is_out() && (!residual.is_finite() || residual <= wanted) {
            return self.turn_back().map(|()| None);
        }
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
        let most = if self.excursion.is_out() { OUT } else { FORCING.0 };
        let forcing = (residual / self.before).powi(2).clamp(enough.min(most), most);
        self.before = residual;
        let from = self.indefinite.modification(residual);
        let is_tangent = self.tangent_at.is_some();
        let (step, by, decrease) = self.descend(forcing, from);
        if !is_tangent {
            self.indefinite.watch(residual, from, by);
        }
        // a step that was halved until nothing moves is none
        let step = step.filter(|accepted| accepted.u != self.now.u);
        if self.iterations == 0 && !is_tangent {
            let starts = &mut self.workspace.indefinite_starts;
            *starts = match (from, by) {
                (Modification::Projected, _) => starts.saturating_sub(1),
                (_, by) if by < Modification::Projected => 0,
                _ => INDEFINITE_STARTS,
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
        self.accept(accepted, decrease).map(|()| None)
    }

    /// A step that decreases the energy or may increase it, by the first modification of the Hessian that
    /// gives one from `from` on, the last modification tried, and the decrease that the first
    /// direction predicts [J].
    fn descend(
        &mut self,
        forcing: f64,
        from: Modification,
    ) -> (Option<Accepted>, Modification, f64) {
        let tolerant = self.excursion.is_allowed();
        let Self { problem, workspace, at, now, last, tangent_at, .. } = self;
        let at = Iterate { u: &now.u, before: last.as_deref(), ..*at };
        let point = Point { at, gradient: &now.gradient };
        // at the old load the Hessian of a stable equilibrium is positive definite; at the new one it need not be
        let is_doubtful = tangent_at.is_none() && self.indefinite.is_doubtful(workspace);
        let time = tangent_at.take().unwrap_or(at.time);
        let tangent = Point { at: Iterate { time, ..at }, ..point };
        let (mut by, mut from) = (from, Some(from));
        let mut predicted = f64::INFINITY;
        while let Some(modification) = from {
            let found = direction(problem, workspace, &tangent, modification, is_doubtful, forcing);
            let Some((modification, direction)) = found else { break };
            by = modification;
            let slope = dot(point.gradient, &direction);
            predicted = predicted.min(0.5 * slope.abs());
            if slope < 0.0
                && let Some(accepted) =
                    line_search(problem, workspace, &point, now.energy, &direction, tolerant)
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

    /// Moves on to the next iterate, or back to where the energy began to grow.
    fn accept(&mut self, accepted: Accepted, decrease: f64) -> Result<(), Failure> {
        if !self.excursion.goes_on(&accepted, &self.now, self.last.as_deref(), decrease) {
            return self.turn_back();
        }
        let next = Evaluated::of(accepted, self.problem, self.workspace, &self.at);
        let before = std::mem::replace(&mut self.now, next);
        self.last = Some(before.u.clone());
        // volumes are off while the energy is
        let is_out = self.excursion.is_out();
        let Some(ballooning) = self.ballooning.as_mut().filter(|_| !is_out) else { return Ok(()) };
        let ends = [&before, &self.now].map(|end| End { u: &end.u, gradient: &end.gradient });
        match ballooning.watch(self.problem, &self.at, ends) {
            Some([start, volume]) => {
                let iterations = self.iterations + 1;
                Err(Failure::Balloons { iterations, start, volume })
            }
            None => Ok(()),
        }
    }

    /// Goes back to where the energy began to grow, and from there a shorter way; from there on it falls in every step.
    fn turn_back(&mut self) -> Result<(), Failure> {
        let Some(start) = self.excursion.end() else { return Ok(()) };
        log::debug!("back to where the energy began to grow");
        (self.now, self.last) = (start.state, start.last);
        let at = Iterate { u: &self.now.u, ..self.at };
        let point = Point { at, gradient: &self.now.gradient };
        let Self { problem, workspace, .. } = self;
        let shorter = line_search(problem, workspace, &point, self.now.energy, &start.step, false);
        shorter.map_or(Ok(()), |accepted| self.accept(accepted, 0.0))
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
        let Evaluated { u, residual, scale, .. } = &self.flat.best;
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
    best: Evaluated,
    mark: f64,
    iterations: usize,
}

impl Flat {
    fn watch(&mut self, now: &Evaluated) {
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
