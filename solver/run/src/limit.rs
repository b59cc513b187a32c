//! How much more pressure than its loads a body bears: the factor at which it balloons or buckles, and at which its
//! largest stretch is that at break; and how much less the pressure rises there than on the way to it.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use mechanics::energy::{ChamberId, Iterate};
use mechanics::forward::{self, Configuration, Problem, Reached, Workspace};
use mechanics::stability::{
    self, Burst, BurstSearch, FirstBurst, FirstLimit, LimitSearch, PressureSlope,
};
use mechanics::stretch::LargestStretch;
use reports::{DirectIterate, Limit, LimitState, LimitStatus, PointKind};
use scene::Scene;
use scene::config::LimitConfig;

use crate::report::results::chambers;
use crate::report::stability::kind_of;

/// What is known on the way to the limit.
struct Way {
    /// The states.
    path: Vec<LimitState>,
    /// Where the material tears, if it is known when.
    burst: Option<BurstSearch>,
    /// Factor from which on states were found by load steps.
    by_load_from: Option<f64>,
}

/// The edges of a run: its limit, its burst and the slope of its pressure.
pub struct Edges {
    /// For the report.
    pub limit: Limit,
    /// The state at the limit, with the softest mode there over all degrees of freedom, where there is one.
    pub at_limit: Option<Box<stability::Limit>>,
    /// The state at which the material tears, where there is one.
    pub burst: Option<Box<Burst>>,
    /// The slope of the pressure at the end, where the tangent is regular.
    pub slope: Option<PressureSlope>,
}

/// The limit of the state at the end of a run, and its burst.
pub fn find(scene: &Scene, problem: &Problem, end: &Iterate, config: &LimitConfig) -> Edges {
    let growing = growing(problem, config);
    let held = problem.with_scaled_pressures(end.time, &growing);
    let mut workspace = Workspace::new(&held);
    let slope = PressureSlope::of(&held, &mut workspace, &configuration(end), &growing).ok();
    let burst = scene.stretch_at_break().map(|at_break| BurstSearch::new(end, at_break));
    let mut way = Way { path: vec![state(&held, end)], burst, by_load_from: None };
    let (stepping, integrator) = (scene.stepping(), scene.integrator(&scene.body, &held));
    let search =
        LimitSearch { problem: &held, rest: end.rest, stepping, most: config.most, integrator };
    let first = search.from(&mut workspace, Reached::of(end), |step| {
        if step.path.is_none() {
            way.by_load_from.get_or_insert(way.last()[0]);
        }
        way.follow(&held, &step.iterate(&held, end.rest));
        let [factor, stretch] = way.last();
        log::info!("towards a limit: {factor:.3} × the pressure, largest stretch {stretch:.2}");
        ControlFlow::Continue(())
    });
    if let FirstLimit::Found(found, _) = &first {
        let Reached { time, u, multipliers } = &found.at;
        way.follow(&held, &Iterate { u, time: *time, multipliers, ..*end });
    }
    let burst = way.burst.as_ref().and_then(|way| {
        let torn = way.found(&held, &mut workspace, end.rest, &stepping);
        at_burst(torn)
    });
    let [stable_to, largest_stretch] = way.last();
    let mut limit = Limit {
        status: LimitStatus::NotFound,
        factor: None,
        kind: None,
        between: None,
        stable_to,
        burst: burst.as_ref().map(|burst| burst.at.time),
        slope: slope.as_ref().map(|slope| slope.value),
        error_bars: BTreeMap::new(),
        largest_stretch,
        reason: None,
        by_load_from: way.by_load_from,
        path: way.path,
        iterates: Vec::new(),
    };
    let mut at_limit = None;
    match first {
        FirstLimit::Found(found, loads) => {
            limit.status = LimitStatus::Found;
            (limit.kind, limit.between) = (Some(kind_of(found.kind)), Some(loads));
            limit.factor = Some(found.at.time);
            limit.iterates = found.history.iter().map(iterate).collect();
            at_limit = Some(found);
        }
        FirstLimit::Between(kind, loads) => {
            limit.status = LimitStatus::Bracketed;
            (limit.kind, limit.between) = (Some(kind_of(kind)), Some(loads));
        }
        FirstLimit::None => limit.status = LimitStatus::StableTo,
        FirstLimit::Unstable => limit.status = LimitStatus::Unstable,
        // nobody stops it here
        FirstLimit::Stopped => {}
        FirstLimit::Lost(None) => limit.reason = Some("too many states".to_owned()),
        FirstLimit::Lost(Some(failure)) => limit.reason = Some(failure.to_string()),
    }
    Edges { limit, at_limit, burst, slope }
}

fn iterate(left: &stability::DirectIterate) -> DirectIterate {
    DirectIterate { residual: left.residual, stiffness: left.stiffness, factor: left.load }
}

/// A state that is no step in time, on its own.
pub fn configuration<'a>(at: &Iterate<'a>) -> Configuration<'a> {
    let Iterate { rest, time, .. } = *at;
    Configuration {
        rest,
        time,
        step: None,
        u: at.u.to_vec(),
        multipliers: at.multipliers.to_vec(),
        balanced_at: None,
    }
}

/// The state at which a body bursts, or in the log why there is none.
fn at_burst(torn: FirstBurst) -> Option<Box<Burst>> {
    match torn {
        FirstBurst::At(burst) => return Some(burst),
        FirstBurst::Never => (),
        FirstBurst::Between([from, to]) => log::warn!(
            "the stretch at break is reached between {from:.4} and {to:.4} × the pressure, but no state there was found"
        ),
        FirstBurst::Beyond(why) => log::warn!("{}", beyond(why.as_ref())),
    }
    None
}

/// What to say of a body that is torn at its pressure, and of which no state with less stretch was found.
pub fn beyond(why: Option<&forward::Failure>) -> String {
    match why {
        None => "its largest stretch is beyond that at break without any pressure".to_owned(),
        Some(why) => {
            format!(
                "its largest stretch is beyond that at break, and none was found at less pressure: {why}"
            )
        }
    }
}

/// The chambers whose pressures grow.
pub fn growing(problem: &Problem, config: &LimitConfig) -> Vec<ChamberId> {
    let chambers = problem.energies.chambers();
    let named = chambers.filter(|(_, c)| config.on.is_empty() || config.on.contains(&c.name));
    named.map(|(id, _)| id).collect()
}

fn state(held: &Problem, at: &Iterate) -> LimitState {
    LimitState {
        factor: at.time,
        // without a load all stretches are 1
        largest_stretch: LargestStretch::of(at.space, at.rest, at.u).value.max(1.0),
        chambers: chambers(&held.energies, at),
    }
}

impl Way {
    /// Takes in a state.
    fn follow(&mut self, held: &Problem, at: &Iterate) {
        if let Some(burst) = &mut self.burst {
            burst.pass(at);
        }
        self.path.push(state(held, at));
    }

    /// Factor and largest stretch of the last state.
    fn last(&self) -> [f64; 2] {
        self.path.last().map_or([1.0; 2], |last| [last.factor, last.largest_stretch])
    }
}

/// The limit for people.
pub fn in_words(limit: &Limit) -> String {
    let times = |factor: f64| format!("{factor:.3} × the pressure");
    let mut text = match (limit.status, limit.kind, limit.factor) {
        (LimitStatus::Found, Some(PointKind::LimitPoint), Some(factor)) => {
            format!("limit: no equilibrium beyond {}", times(factor))
        }
        (LimitStatus::Found, _, Some(factor)) => {
            format!("limit: it buckles to another branch at {}", times(factor))
        }
        (LimitStatus::StableTo, ..) => {
            format!("limit: stable to {} ([limit] most)", times(limit.stable_to))
        }
        (LimitStatus::Unstable, ..) => {
            "limit: the state at the end is not stable: it has passed one".to_owned()
        }
        (LimitStatus::Bracketed, ..) => {
            let [from, to] = limit.between.unwrap_or([limit.stable_to; 2]);
            format!("limit: between {} and {}", times(from.min(to)), times(from.max(to)))
        }
        _ => {
            let reason = limit.reason.as_deref().unwrap_or("the path ends there");
            format!("limit: none found, stable to {}: {reason}", times(limit.stable_to))
        }
    };
    if let Some(from) = limit.by_load_from {
        text += &format!(
            "; by load steps from {} on, where the path could not be followed",
            times(from)
        );
    }
    if let Some(burst) = limit.burst {
        text += &format!("; the stretch at break is reached at {}", times(burst));
    }
    if let Some(slope) = limit.slope {
        text += &format!("; slope of the pressure {slope:.3} of that in proportion");
    }
    text
}
