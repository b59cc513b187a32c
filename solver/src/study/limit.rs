//! How much more pressure than its loads a body bears: the factor at which it balloons or buckles, and at which it
//! tears.

use anyhow::Result;
use mechanics::energy::{ChamberId, Iterate};
use mechanics::forward::{
    self, ArcFollower, ArcLength, ArcPoint, Configuration, Kind, LoadStep, Passed, Problem,
    Reached, TimeStepper, Workspace,
};
use mechanics::stretch::Stretches;
use reports::{DirectIterate, Limit, LimitStatus, PointKind};
use scene::Scene;
use scene::config::LimitConfig;

/// First step of the factor.
const FIRST: f64 = 0.05;
/// States from the full load to the limit, at most.
const STATES: usize = 300;

/// What is known on the way to the limit.
struct Way {
    /// Factor and largest stretch of the last state.
    last: (f64, f64),
    /// Factor at which the material tears.
    burst: Option<f64>,
}

/// The limit of the state at the end of a run, with the softest mode there over all degrees of freedom, where there is
/// one.
///
/// # Errors
/// When surfaces or steps cannot be made.
pub fn find(
    scene: &Scene,
    problem: &Problem,
    end: &Iterate,
    config: &LimitConfig,
) -> Result<(Limit, Option<Vec<f64>>)> {
    let held = problem.held(end.time, &growing(problem, config));
    let mut workspace = Workspace::new(&held);
    let (u, multipliers) = (end.u.to_vec(), end.multipliers.to_vec());
    let reached = Reached { time: end.time, u, multipliers };
    let integrator = scene.integrator(&scene.body, &held);
    let mut stepper = TimeStepper::within(scene.stepping(), integrator, reached);
    let smallest = scene.config.solver.smallest_load_step;
    let path = ArcLength { first: FIRST, largest: f64::INFINITY, smallest, end: config.most };
    let mut follower = ArcFollower::new(path);
    let mut way = Way { last: (end.time, stretch(scene, end)), burst: None };
    if at_break(scene).is_some_and(|limit| way.last.1 >= limit) {
        way.burst = Some(end.time);
    }
    for states in 1..=STATES {
        let step = match follower.next(&mut stepper, &held, &mut workspace, end.rest) {
            Ok(step) => step,
            Err(unreached) => {
                log::debug!("no limit found: {unreached}");
                return Ok((none(LimitStatus::NotFound, &way), None));
            }
        };
        let Some(point) = step.path.as_deref() else { continue };
        if states == 1 && point.stability.negative > 0 && point.passed.is_empty() {
            return Ok((none(LimitStatus::Unstable, &way), None));
        }
        if point.passed.is_empty() {
            way.follow(scene, &step.iterate(&held, end.rest));
            let (factor, stretch) = way.last;
            log::info!("towards a limit: {factor:.3} × the pressure, largest stretch {stretch:.2}");
            if step.ends_time_step {
                return Ok((none(LimitStatus::StableTo, &way), None));
            }
            continue;
        }
        return Ok(sharp(scene, (&held, &mut workspace), end, (&step, point), way));
    }
    Ok((none(LimitStatus::NotFound, &way), None))
}

/// The chambers whose pressures grow.
fn growing(problem: &Problem, config: &LimitConfig) -> Vec<ChamberId> {
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
        iterates: Vec::new(),
    }
}

/// The limit by the direct method, from the first state beyond it.
fn sharp(
    scene: &Scene,
    (held, workspace): (&Problem, &mut Workspace),
    end: &Iterate,
    (step, point): (&LoadStep, &ArcPoint),
    mut way: Way,
) -> (Limit, Option<Vec<f64>>) {
    let (kind, loads) = match point.passed[0] {
        Passed::LimitPoint(loads) => (Kind::LimitPoint, loads),
        Passed::Bifurcation(loads) => (Kind::Bifurcation, loads),
    };
    let (u, multipliers) = (step.u.clone(), step.multipliers.clone());
    let (time, rest) = (step.time, end.rest);
    let start = Configuration { rest, time, step: step.step.as_ref(), u, multipliers };
    let newton = scene.stepping().newton;
    let found = forward::Limit::near(held, workspace, &start, kind, &newton);
    let known = Limit {
        kind: Some(match kind {
            Kind::LimitPoint => PointKind::LimitPoint,
            Kind::Bifurcation => PointKind::Bifurcation,
        }),
        between: Some(loads),
        ..none(LimitStatus::Bracketed, &way)
    };
    let found = match found {
        // that of another point would be a wrong one
        Ok(found) if is_between(found.load, loads, kind) => found,
        Ok(found) => {
            log::debug!("the direct method went to {} from {loads:?}", found.load);
            return (known, None);
        }
        Err(failure) => {
            log::debug!("the direct method failed: {failure}");
            return (known, None);
        }
    };
    way.follow(scene, &Iterate { u: &found.u, time: found.load, ..*end });
    let iterate = |left: &forward::Left| DirectIterate {
        residual: left.residual,
        stiffness: left.stiffness,
        factor: left.load,
    };
    let iterates = found.history.iter().map(iterate).collect();
    let (status, burst) = (LimitStatus::Found, way.burst);
    let (factor, stable_to) = (Some(found.load), found.load);
    let largest_stretch = way.last.1;
    (
        Limit { status, factor, burst, stable_to, largest_stretch, iterates, ..known },
        Some(found.mode),
    )
}

/// Whether a load is that of a singular point between two states: above both where the load turns.
fn is_between(load: f64, [from, to]: [f64; 2], kind: Kind) -> bool {
    let (low, high) = (from.min(to), from.max(to));
    match kind {
        Kind::LimitPoint => load >= high - 1e-9 && load <= high + (high - low).max(0.05 * high),
        Kind::Bifurcation => load >= low && load <= high,
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
        _ => format!("limit: none found, stable to {}", times(limit.stable_to)),
    };
    if let Some(burst) = limit.burst {
        text += &format!("; the stretch at break is reached at {}", times(burst));
    }
    text
}
