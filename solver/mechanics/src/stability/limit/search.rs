//! The first limit on the path of a state whose loads grow.
//!
//! Where facets of a mesh slide over each other, forces of contact have kinks. A path may turn back at one, so that a
//! corrector goes to and fro between both sides, or the body snaps by little. From such a place on, states are found
//! [by load steps](super::load_steps), and a limit is what no stable state near by lies beyond.

use std::ops::ControlFlow;

use mesh::Vec3;

use super::Limit;
use super::load_steps::{End, LoadSteps};
use crate::forward::{
    Configuration, Failure, Integrator, LoadStep, Problem, Reached, SingularPoint, Singularity,
    Stepping, TimeStepper, Workspace,
};
use crate::stability::{ArcLength, Continuation};

/// First step of the load.
const FIRST: f64 = 0.05;
/// States from the start to the limit, at most.
const STATES: usize = 300;
/// How much more than at the state before it the load of a limit point may be, beside its own.
const HIGHER: f64 = 0.05;
/// Relative difference of loads that is none.
const ROUNDING: f64 = 1e-9;

/// What was found of the first limit.
pub enum FirstLimit {
    /// A state, between those of two loads.
    Found(Box<Limit>, [f64; 2]),
    /// One of a kind between two loads, at which no state was found.
    Between(Singularity, [f64; 2]),
    /// None up to the largest load.
    None,
    /// The start is not stable.
    Unstable,
    /// Not sought further, as the observer said.
    Stopped,
    /// No next state on the path, and why; none after too many.
    Lost(Option<Failure>),
}

/// Where a path leads.
enum Along {
    /// To the largest load.
    Whole,
    /// Nowhere: its start is not stable.
    Unstable,
    /// As far as the observer wanted.
    Stopped,
    /// To what was found, from the last stable state.
    To(Reached, FirstLimit),
}

/// A search for the first limit.
pub struct LimitSearch<'a> {
    /// The body, whose loads grow ([`Problem::with_scaled_pressures`]).
    pub problem: &'a Problem,
    /// Rest vertices [m].
    pub rest: &'a [Vec3],
    /// How equilibria are found.
    pub stepping: Stepping,
    /// The largest load.
    pub most: f64,
    /// The time step that the states are in.
    pub integrator: Integrator,
}

impl LimitSearch<'_> {
    /// The first limit from a state on. Every state on the way is shown to `observe`, which may end it; one that is no
    /// point of a path was found by a load step.
    pub fn from(
        &self,
        workspace: &mut Workspace,
        start: Reached,
        mut observe: impl FnMut(&LoadStep) -> ControlFlow<()>,
    ) -> FirstLimit {
        let (last, found) = match self.along(workspace, start, &mut observe) {
            Along::Whole => return FirstLimit::None,
            Along::Unstable => return FirstLimit::Unstable,
            Along::Stopped => return FirstLimit::Stopped,
            Along::To(last, found) => (last, found),
        };
        let kinks = self.problem.energies.contact().is_some();
        match &found {
            FirstLimit::Lost(None | Some(Failure::Folded | Failure::Interrupted)) => return found,
            FirstLimit::Lost(_) => {}
            _ if !kinks => return found,
            _ => {}
        }
        let begun = last.time;
        let Self { problem, rest, stepping, most, .. } = self;
        let load_steps = LoadSteps { problem, rest, stepping, most: *most };
        let came = load_steps.from(workspace, last, &mut observe);
        let last = came.last.time;
        match (came.end, found) {
            (End::Most, _) => FirstLimit::None,
            (End::Stopped, _) => FirstLimit::Stopped,
            (_, found @ (FirstLimit::Found(..) | FirstLimit::Between(..))) if last <= begun => {
                found
            }
            (end, found) => {
                let (above, otherwise) = match (end, found) {
                    (End::Limit(to), _) => {
                        (to, FirstLimit::Between(Singularity::LimitPoint, [last, to]))
                    }
                    (_, FirstLimit::Lost(why)) => (self.most, FirstLimit::Lost(why)),
                    _ => (self.most, FirstLimit::Lost(None)),
                };
                // next to the limit, the path may be smooth enough for a direct method
                match self.along(workspace, came.last, |_| ControlFlow::Continue(())) {
                    Along::To(_, FirstLimit::Found(limit, loads)) if limit.at.time <= above => {
                        FirstLimit::Found(limit, loads)
                    }
                    _ => otherwise,
                }
            }
        }
    }

    /// Follows the path from a state to the first singular point.
    fn along(
        &self,
        workspace: &mut Workspace,
        from: Reached,
        mut observe: impl FnMut(&LoadStep) -> ControlFlow<()>,
    ) -> Along {
        let mut stepper = TimeStepper::within(self.stepping, self.integrator.clone(), from);
        let (first, smallest) = (FIRST, self.stepping.smallest);
        let path = ArcLength { first, largest: f64::INFINITY, smallest, end: self.most };
        let mut path = Continuation::new(path);
        for states in 1..=STATES {
            let step = match path.next(&mut stepper, self.problem, workspace, self.rest) {
                Ok(step) => step,
                Err(unreached) => {
                    let lost = FirstLimit::Lost(Some(unreached.failure));
                    return Along::To(last(&stepper, 0), lost);
                }
            };
            let Some(point) = step.path.as_deref() else { continue };
            match point.passed.first() {
                None if states == 1 && point.stability.negative > 0 => return Along::Unstable,
                None => {
                    let goes_on = observe(&step);
                    if !step.ends_time_step && goes_on.is_break() {
                        return Along::Stopped;
                    }
                }
                Some(&passed) => {
                    let nearer = match passed.kind {
                        Singularity::LimitPoint => {
                            path.narrowed(&stepper, self.problem, workspace, self.rest)
                        }
                        Singularity::Bifurcation => None,
                    };
                    let found = self.next_to(workspace, &nearer.unwrap_or(step), passed);
                    return Along::To(last(&stepper, 1), found);
                }
            }
            if step.ends_time_step {
                return Along::Whole;
            }
        }
        Along::To(last(&stepper, 0), FirstLimit::Lost(None))
    }

    /// The limit next to a state, between two loads.
    fn next_to(
        &self,
        workspace: &mut Workspace,
        state: &LoadStep,
        SingularPoint { kind, loads }: SingularPoint,
    ) -> FirstLimit {
        let (u, multipliers) = (state.u.clone(), state.multipliers.clone());
        let step = state.step.as_ref();
        let start = Configuration {
            rest: self.rest,
            time: state.time,
            step,
            u,
            multipliers,
            balanced_at: None,
        };
        match Limit::near(self.problem, workspace, &start, kind, &self.stepping.newton) {
            Ok(found) if is_between(found.at.time, loads, kind) => {
                return FirstLimit::Found(Box::new(found), loads);
            }
            // that of another point would be a wrong one
            Ok(found) => log::debug!("the direct method went to {} from {loads:?}", found.at.time),
            Err(failure) => log::debug!("the direct method failed: {failure}"),
        }
        FirstLimit::Between(kind, loads)
    }
}

/// The last state of a path, or one before it.
fn last(stepper: &TimeStepper, back: usize) -> Reached {
    let states = &stepper.progress.last;
    states[states.len().saturating_sub(1 + back)].clone()
}

/// Whether a load is that of a singular point between two states: above both where the load turns.
fn is_between(load: f64, [from, to]: [f64; 2], kind: Singularity) -> bool {
    let (low, high) = (from.min(to), from.max(to));
    match kind {
        Singularity::LimitPoint => {
            load >= high - ROUNDING && load <= high + (high - low).max(HIGHER * high)
        }
        Singularity::Bifurcation => load >= low && load <= high,
    }
}
