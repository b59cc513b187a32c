//! The first limit on the path of a state whose loads grow.

use mesh::Vec3;

use super::Limit;
use crate::energy::Iterate;
use crate::forward::{
    ArcFollower, ArcLength, Configuration, Failure, Integrator, Kind, LoadStep, Passed, Problem,
    Reached, Stepping, TimeStepper, Workspace,
};

/// First step of the load.
const FIRST: f64 = 0.05;
/// States from the start to the limit, at most.
const STATES: usize = 300;
/// How much more than at the state before it the load of a limit point may be, beside its own.
const HIGHER: f64 = 0.05;
/// Relative difference of loads that is none.
const ROUNDING: f64 = 1e-9;

/// What was found of the first limit.
pub enum First {
    /// A state, between those of two loads.
    Found(Box<Limit>, [f64; 2]),
    /// One of a kind between two loads, at which no state was found.
    Between(Kind, [f64; 2]),
    /// None up to the largest load.
    None,
    /// The start is not stable.
    Unstable,
    /// No next state on the path, and why; none after too many.
    Lost(Option<Failure>),
}

/// How the first limit is sought.
#[derive(Clone, Copy, Debug)]
pub struct LimitSearch {
    /// How equilibria are found.
    pub stepping: Stepping,
    /// The largest load.
    pub most: f64,
}

impl LimitSearch {
    /// The first limit of a problem whose loads grow from a state on ([`Problem::held`]). Every state on the way is
    /// shown to `observe`.
    pub fn from(
        &self,
        held: &Problem,
        workspace: &mut Workspace,
        (start, integrator): (&Iterate, Integrator),
        mut observe: impl FnMut(&LoadStep),
    ) -> First {
        let reached = Reached {
            time: start.time,
            u: start.u.to_vec(),
            multipliers: start.multipliers.to_vec(),
        };
        let rest = start.rest;
        let mut stepper = TimeStepper::within(self.stepping, integrator, reached);
        let largest = f64::INFINITY;
        let path =
            ArcLength { first: FIRST, largest, smallest: self.stepping.smallest, end: self.most };
        let mut follower = ArcFollower::new(path);
        for states in 1..=STATES {
            let step = match follower.next(&mut stepper, held, workspace, rest) {
                Ok(step) => step,
                Err(unreached) => return First::Lost(Some(unreached.failure)),
            };
            let Some(point) = step.path.as_deref() else { continue };
            match point.passed.first() {
                None if states == 1 && point.stability.negative > 0 => return First::Unstable,
                None if step.ends_time_step => {
                    observe(&step);
                    return First::None;
                }
                None => observe(&step),
                Some(passed) => {
                    let (kind, loads) = match *passed {
                        Passed::LimitPoint(loads) => (Kind::LimitPoint, loads),
                        Passed::Bifurcation(loads) => (Kind::Bifurcation, loads),
                    };
                    let nearer = match kind {
                        Kind::LimitPoint => follower.narrowed(&stepper, held, workspace, rest),
                        Kind::Bifurcation => None,
                    };
                    let nearest = nearer.as_ref().unwrap_or(&step);
                    return self.sharp(held, workspace, (rest, nearest), (kind, loads));
                }
            }
        }
        First::Lost(None)
    }

    /// The limit next to a state, between two loads.
    fn sharp(
        &self,
        held: &Problem,
        workspace: &mut Workspace,
        (rest, nearest): (&[Vec3], &LoadStep),
        (kind, loads): (Kind, [f64; 2]),
    ) -> First {
        let LoadStep { time, step, u, multipliers, .. } = nearest;
        let (u, multipliers) = (u.clone(), multipliers.clone());
        let start = Configuration { rest, time: *time, step: step.as_ref(), u, multipliers };
        match Limit::near(held, workspace, &start, kind, &self.stepping.newton) {
            Ok(found) if is_between(found.load, loads, kind) => {
                First::Found(Box::new(found), loads)
            }
            Ok(found) => {
                // that of another point would be a wrong one
                log::debug!("the direct method went to {} from {loads:?}", found.load);
                First::Between(kind, loads)
            }
            Err(failure) => {
                log::debug!("the direct method failed: {failure}");
                First::Between(kind, loads)
            }
        }
    }
}

/// Whether a load is that of a singular point between two states: above both where the load turns.
fn is_between(load: f64, [from, to]: [f64; 2], kind: Kind) -> bool {
    let (low, high) = (from.min(to), from.max(to));
    match kind {
        Kind::LimitPoint => {
            load >= high - ROUNDING && load <= high + (high - low).max(HIGHER * high)
        }
        Kind::Bifurcation => load >= low && load <= high,
    }
}
