//! How much more pressure than its loads a body bears: the factor at which it balloons or buckles, and at which it
//! tears.

use mechanics::energy::{ChamberId, Iterate};
use mechanics::forward::{self, First, Kind, LimitSearch, Problem, Workspace};
use mechanics::stretch::Stretches;
use reports::{DirectIterate, Limit, LimitStatus, PointKind};
use scene::Scene;
use scene::config::LimitConfig;

/// What is known on the way to the limit.
struct Way {
    /// Factor and largest stretch of the last state.
    last: (f64, f64),
    /// Factor at which the material tears.
    burst: Option<f64>,
    /// Factor from which on states were found by load steps.
    by_load_from: Option<f64>,
}

/// The limit of the state at the end of a run, with the softest mode there over all degrees of freedom, where there is
/// one.
#[must_use]
pub fn find(
    scene: &Scene,
    problem: &Problem,
    end: &Iterate,
    config: &LimitConfig,
) -> (Limit, Option<Vec<f64>>) {
    let held = problem.held(end.time, &growing(problem, config));
    let mut workspace = Workspace::new(&held);
    let mut way = Way { last: (end.time, stretch(scene, end)), burst: None, by_load_from: None };
    if at_break(scene).is_some_and(|limit| way.last.1 >= limit) {
        way.burst = Some(end.time);
    }
    let search = LimitSearch { stepping: scene.stepping(), most: config.most };
    let start = (end, scene.integrator(&scene.body, &held));
    let first = search.from(&held, &mut workspace, start, |step| {
        if step.path.is_none() {
            way.by_load_from.get_or_insert(way.last.0);
        }
        way.follow(scene, &step.iterate(&held, end.rest));
        let (factor, stretch) = way.last;
        log::info!("towards a limit: {factor:.3} × the pressure, largest stretch {stretch:.2}");
    });
    match first {
        First::Found(found, loads) => {
            way.follow(scene, &Iterate { u: &found.u, time: found.load, ..*end });
            let limit = Limit { between: Some(loads), ..at(&found, &way) };
            (limit, Some(found.mode))
        }
        First::Between(kind, loads) => {
            let (kind, between) = (Some(kind_of(kind)), Some(loads));
            (Limit { kind, between, ..none(LimitStatus::Bracketed, &way) }, None)
        }
        First::None => (none(LimitStatus::StableTo, &way), None),
        First::Unstable => (none(LimitStatus::Unstable, &way), None),
        First::Lost(failure) => {
            let reason = failure.map_or_else(|| "too many states".to_owned(), |f| f.to_string());
            (Limit { reason: Some(reason), ..none(LimitStatus::NotFound, &way) }, None)
        }
    }
}

/// The chambers whose pressures grow.
#[must_use]
pub fn growing(problem: &Problem, config: &LimitConfig) -> Vec<ChamberId> {
    let chambers = problem.energies.chambers();
    let named = chambers.filter(|(_, c)| config.on.is_empty() || config.on.contains(&c.name));
    named.map(|(id, _)| id).collect()
}

fn stretch(scene: &Scene, at: &Iterate) -> f64 {
    Stretches::of(at.space, at.rest, at.u, scene.stretch_limits()).largest
}

fn at_break(scene: &Scene) -> Option<f64> {
    scene.stretch_limits().at_break
}

impl Way {
    /// Takes in a state: the factor at which the stretch passes that at break is between the last one and it.
    fn follow(&mut self, scene: &Scene, at: &Iterate) {
        let (factor, largest) = (at.time, stretch(scene, at));
        if let Some(limit) = at_break(scene)
            && self.burst.is_none()
            && largest >= limit
        {
            let part = (limit - self.last.1) / (largest - self.last.1);
            self.burst = Some(self.last.0 + part * (factor - self.last.0));
        }
        self.last = (factor, largest);
    }
}

/// A run without a limit, and how far it came.
fn none(status: LimitStatus, way: &Way) -> Limit {
    Limit {
        status,
        factor: None,
        kind: None,
        between: None,
        stable_to: way.last.0,
        burst: way.burst,
        largest_stretch: way.last.1,
        reason: None,
        by_load_from: way.by_load_from,
        iterates: Vec::new(),
    }
}

/// A limit that was found.
fn at(found: &forward::Limit, way: &Way) -> Limit {
    let iterate = |left: &forward::Left| DirectIterate {
        residual: left.residual,
        stiffness: left.stiffness,
        factor: left.load,
    };
    Limit {
        kind: Some(kind_of(found.kind)),
        factor: Some(found.load),
        iterates: found.history.iter().map(iterate).collect(),
        ..none(LimitStatus::Found, way)
    }
}

fn kind_of(kind: Kind) -> PointKind {
    match kind {
        Kind::LimitPoint => PointKind::LimitPoint,
        Kind::Bifurcation => PointKind::Bifurcation,
    }
}

/// The limit for people.
#[must_use]
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
    text
}
