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
use super::{Configuration, Problem, Uncertified, Workspace};
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

/// Why there is no equilibrium. Not a panic: the caller decides.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The start is not admissible.
    #[error("the starting shape has inverted elements, or an energy or forces that are not finite")]
    Inadmissible,
    /// Too many iterations.
    #[error(
        "{iterations} Newton iterations were not enough: residual {residual:.2e} N, wanted {wanted:.2e} N"
    )]
    IterationLimit {
        /// Iterations made.
        iterations: usize,
        /// Residual reached [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
    },
    /// A chamber balloons, and its walls bear less the more it grows.
    #[error(
        "a chamber balloons: its walls bear less the more it grows, from {start:.3e} to {volume:.3e} m³ in \
         {iterations} Newton iterations"
    )]
    Balloons {
        /// Iterations made.
        iterations: usize,
        /// Volume at the start [m³].
        start: f64,
        /// Volume after them [m³].
        volume: f64,
    },
    /// No step decreases the energy.
    #[error(
        "no Newton step decreases the energy after {iterations} iterations: residual {residual:.2e} N, wanted {wanted:.2e} N"
    )]
    Stalled {
        /// Iterations made.
        iterations: usize,
        /// Residual reached [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
    },
    /// The forces balance, but a chamber does not take its prescribed volume.
    #[error(
        "the forces balance, but a chamber with the prescribed volume {wanted:.6e} m³ has \
         {volume:.6e} m³"
    )]
    Volume {
        /// Volume reached [m³].
        volume: f64,
        /// Volume prescribed [m³].
        wanted: f64,
    },
    /// Steps are within rounding, but the residual is not.
    #[error(
        "Newton's method stagnated after {iterations} iterations: residual {residual:.2e} N, \
         wanted {wanted:.2e} N, floor by rounding about {floor:.1e} N"
    )]
    Stagnated {
        /// Iterations made.
        iterations: usize,
        /// Smallest residual reached [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
        /// Estimated floor by rounding [N].
        floor: f64,
        /// The forces that have to balance [N].
        scale: f64,
    },
    /// The forces balance, but an element is turned inside out, or might be.
    #[error("the forces balance, but {0}")]
    Uncertified(#[from] Uncertified),
    /// The forces balance, but an energy objects to the state.
    #[error("the forces balance, but {0}")]
    Objection(String),
    /// Supports or obstacles would push surfaces through each other.
    #[error(
        "supports or obstacles meet a surface after {:.1} % of their motion in this step",
        100.0 * free
    )]
    Blocked {
        /// Fraction of the motion that is free.
        free: f64,
    },
    /// The tangent is singular: a body that may move freely, or a state at which several branches meet.
    #[error("the tangent stiffness is singular")]
    Singular,
    /// Nothing depends on the load.
    #[error("no load: nothing changes between t = 0 and t = 1")]
    NoLoad,
    /// The next state is none of the same branch.
    #[error("the path would turn by {degrees:.0}° from one state to the next")]
    Strayed {
        /// Angle between the directions of the path [°].
        degrees: f64,
    },
    /// Facets meet between which nothing acts.
    #[error(
        "facets of the surface meet on the way to the next state, and no contact keeps them apart: those of one \
         edge or wall, which solid lies between; the mesh is too coarse there"
    )]
    Folded,
    /// Who watches has broken off.
    #[error("interrupted")]
    Interrupted,
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
    ///
    /// # Errors
    /// [`Failure`]; the displacement is then that of the last iterate.
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
    ///
    /// # Errors
    /// [`Failure`]; the displacement is then that of the last iterate.
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
        let mut now = reached(problem, workspace, &at, first);
        let result = self.iterate(problem, workspace, &at, &mut now, residuals);
        state.u = now.u;
        result
    }

    /// Iterates from `now`; of `at` all but the displacement is used.
    fn iterate(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        at: &Iterate,
        now: &mut State,
        residuals: &mut Vec<f64>,
    ) -> Result<Converged, Failure> {
        let (mut before, mut within_rounding) = (f64::INFINITY, false);
        let mut peak = 0.0_f64;
        let start = Iterate { u: &now.u, ..*at };
        let mut ballooning = self.ballooned.map(|times| Ballooning::from(problem, &start, times));
        let mut indefinite = Indefinite::expected(workspace.indefinite_starts > 0);
        let mut flat = Flat { best: now.clone(), mark: f64::INFINITY, iterations: 0 };
        for iterations in 0.. {
            peak = peak.max(now.scale);
            let (residual, wanted) = (now.residual, self.wanted(now.scale, peak));
            log::debug!("newton {iterations}  |g| {residual:.2e} N  energy {:.9e} J", now.energy);
            let (time, iteration) = (at.time, iterations);
            if workspace.tell(&Event::Iterate { time, iteration, residual, wanted }).is_break() {
                return Err(Failure::Interrupted);
            }
            residuals.push(residual);
            // an infinite one is within a tolerance that is infinite
            if !residual.is_finite() {
                return Err(Failure::Inadmissible);
            }
            if residual <= wanted {
                return Ok(Converged { iterations, residual, wanted, floor: None, peak });
            }
            flat.watch(now);
            if iterations == self.iterations {
                if within_rounding {
                    *now = flat.best;
                    return self.stagnated(problem, workspace, at, now, iterations, peak);
                }
                return Err(Failure::IterationLimit { iterations, residual, wanted });
            }
            // no more accurate than the tolerance needs
            let enough = (LINEAR_RESIDUAL * wanted / residual).clamp(FORCING.1, FORCING.0);
            let forcing = (residual / before).powi(2).clamp(enough, FORCING.0);
            before = residual;
            let point = Point { at: Iterate { u: &now.u, ..*at }, gradient: &now.gradient };
            let from = indefinite.modification(residual);
            let (step, by, decrease) = step(problem, workspace, &point, now.energy, forcing, from);
            indefinite.watch(residual, from, by);
            // a step that was halved until nothing moves is none
            let step = step.filter(|accepted| accepted.u != now.u);
            if iterations == 0 {
                workspace.indefinite_starts = match (from, by) {
                    (Modification::Projected, _) => workspace.indefinite_starts.saturating_sub(1),
                    (_, by) if by < Modification::Projected => 0,
                    _ => MODIFIED_STEPS,
                };
            }
            within_rounding = decrease <= ENERGY_ROUNDING * now.energy.abs();
            if within_rounding && (step.is_none() || flat.iterations >= STALLED_ITERATIONS) {
                *now = flat.best;
                return self.stagnated(problem, workspace, at, now, iterations, peak);
            }
            let Some(accepted) = step else {
                // energies that cancel each other have more rounding than their sum shows
                let best = &flat.best;
                return match self.stagnated(problem, workspace, at, best, iterations, peak) {
                    Ok(converged) => {
                        *now = flat.best;
                        Ok(converged)
                    }
                    Err(_) => Err(Failure::Stalled { iterations, residual, wanted }),
                };
            };
            let next = reached(problem, workspace, at, accepted);
            let before = std::mem::replace(now, next);
            if let Some(ballooning) = &mut ballooning {
                let ends = [&before, &*now].map(|end| End { u: &end.u, gradient: &end.gradient });
                if let Some([start, volume]) = ballooning.watch(problem, at, ends) {
                    let iterations = iterations + 1;
                    return Err(Failure::Balloons { iterations, start, volume });
                }
            }
        }
        unreachable!("the loop ends by returning")
    }

    /// Residual of an equilibrium [N] where forces of a scale balance, and of `peak` at most were to.
    /// Without loads only the residual itself is left to compare with, so that the past counts.
    pub(super) fn wanted(&self, scale: f64, peak: f64) -> f64 {
        let negligible = self.negligible.min(peak / PREVAILING_FORCES);
        (self.relative * scale).max(self.absolute).max(negligible)
    }

    /// Whether a residual that falls no further is as small as rounding allows.
    fn stagnated(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        at: &Iterate,
        best: &State,
        iterations: usize,
        peak: f64,
    ) -> Result<Converged, Failure> {
        let (residual, scale, wanted) = (best.residual, best.scale, self.wanted(best.scale, peak));
        let floor = workspace.rounding_floor(problem, &Iterate { u: &best.u, ..*at });
        log::debug!("residual {residual:.2e} N does not fall; floor by rounding {floor:.1e} N");
        if residual <= floor {
            return Ok(Converged { iterations, residual, wanted, floor: Some(floor), peak });
        }
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

/// A step that decreases the energy, by the first modification of the Hessian that
/// gives one from `from` on, the last modification tried, and the decrease that the first
/// direction predicts [J].
fn step(
    problem: &Problem,
    workspace: &mut Workspace,
    point: &Point,
    energy: f64,
    forcing: f64,
    from: Modification,
) -> (Option<Accepted>, Modification, f64) {
    let (mut by, mut from) = (from, Some(from));
    let mut predicted = f64::INFINITY;
    while let Some(modification) = from {
        let found = direction(problem, workspace, point, modification, forcing);
        let Some((modification, direction)) = found else { break };
        by = modification;
        let slope = dot(point.gradient, &direction);
        predicted = predicted.min(0.5 * slope.abs());
        if slope < 0.0
            && let Some(accepted) = line_search(problem, workspace, point, energy, &direction)
        {
            log::debug!("{modification:?} step");
            return (Some(accepted), by, predicted);
        }
        log::debug!("no {modification:?} step");
        // other directions have no digits to compare either
        from = modification.next().filter(|_| predicted > ENERGY_ROUNDING * energy.abs());
    }
    (None, by, predicted)
}
