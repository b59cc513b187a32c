//! The limit of a run: the factor on the pressures at which the body balloons or buckles, as a term of the objective.
//!
//! w (least − t)₊²,   t the factor, at most that up to which a limit is sought
//!
//! Next to a run that is linearised its limit is sought by the direct method, from the limit there and its first-order
//! change with the rest shape; from a run that is not, or where another mode is soft as well, along the path from the
//! equilibrium on.

use std::sync::Arc;

use mechanics::adjoint::{Gradient, Grown};
use mechanics::energy::{ChamberId, Iterate};
use mechanics::forward::{
    Configuration, First, Kind, Limit, LimitSearch, Problem, Trajectory, Workspace,
    solve_multipliers,
};
use mesh::Vec3;
use scene::config::LimitGoal;
use serde::{Deserialize, Serialize};

use super::{Rejected, Run, Scenario};
use crate::study::limit::growing;

/// Change of the factor from the limit of a nearby run, relative to it, above which it may be another limit.
const NEARBY: f64 = 0.2;

/// How far a run is from its limit.
#[derive(Clone)]
pub struct Margin {
    /// Factor on the pressures at the limit, or up to which there is none [1].
    pub factor: f64,
    /// The limit; none where it was not reached.
    pub(super) at: Option<Arc<AtLimit>>,
}

/// The state at a limit.
pub(super) struct AtLimit {
    kind: Kind,
    /// Displacement [m].
    u: Vec<f64>,
}

/// What a checkpoint has of a margin; the displacement lies in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedMargin {
    factor: f64,
    kind: Option<Kind>,
}

impl Margin {
    /// What is kept beside the displacement.
    #[must_use]
    pub fn saved(&self) -> SavedMargin {
        SavedMargin { factor: self.factor, kind: self.at.as_ref().map(|at| at.kind) }
    }

    /// The displacement at the limit [m]; zeros where none was reached.
    #[must_use]
    pub fn displacement(&self, dofs: usize) -> Vec<f64> {
        self.at.as_ref().map_or_else(|| vec![0.0; dofs], |at| at.u.clone())
    }

    /// A margin as it was kept.
    #[must_use]
    pub fn of(saved: SavedMargin, u: Vec<f64>) -> Self {
        let at = saved.kind.map(|kind| Arc::new(AtLimit { kind, u }));
        Self { factor: saved.factor, at }
    }

    fn found(limit: Limit) -> Self {
        let Limit { load, kind, u, .. } = limit;
        Self { factor: load, at: Some(Arc::new(AtLimit { kind, u })) }
    }
}

/// How much a factor counts in an objective.
pub(super) fn counts(goal: &LimitGoal, factor: f64) -> f64 {
    (goal.least - factor).max(0.0).powi(2)
}

/// The problem whose pressures grow, and its end.
struct Growing<'a> {
    held: Problem,
    chambers: Vec<ChamberId>,
    rest: &'a [Vec3],
    time: f64,
}

impl<'a> Growing<'a> {
    /// The state at a limit of this problem.
    fn state(&self, workspace: &mut Workspace, factor: f64, at: &AtLimit) -> Configuration<'a> {
        let here = self.held.iterate(self.rest, &at.u, factor);
        let multipliers = solve_multipliers(&self.held, workspace, &here);
        Configuration { rest: self.rest, time: factor, step: None, u: at.u.clone(), multipliers }
    }

    /// A direct method from a state.
    fn near(
        &self,
        workspace: &mut Workspace,
        search: &LimitSearch,
        (start, kind): (&Configuration, Kind),
    ) -> Option<Limit> {
        Limit::near(&self.held, workspace, start, kind, &search.stepping.newton).ok()
    }

    /// A direct method from the limit of a run with another rest shape, of which it is a little away.
    fn next_to(
        &self,
        workspace: &mut Workspace,
        search: &LimitSearch,
        (other, factor, at): (&Growing, f64, &AtLimit),
    ) -> Option<Limit> {
        let there = other.state(workspace, factor, at);
        let motion: Vec<Vec3> = self.rest.iter().zip(other.rest).map(|(x, y)| x - y).collect();
        let moved = Limit::predicted(&other.held, workspace, &there, at.kind, &motion).ok()?;
        let start = Configuration { rest: self.rest, ..moved };
        let limit = self.near(workspace, search, (&start, at.kind))?;
        let next = (limit.load / factor - 1.0).abs() < NEARBY;
        (next && limit.others == 0 && limit.load > self.time).then_some(limit)
    }
}

impl Scenario {
    fn growing<'a>(&self, problem: &Problem, rest: &'a [Vec3]) -> Option<Growing<'a>> {
        let (config, time) = (self.scene.config.limit.as_ref()?, self.times[0]);
        let chambers = growing(problem, config);
        Some(Growing { held: problem.held(time, &chambers), chambers, rest, time })
    }

    fn search(&self) -> Option<LimitSearch> {
        let most = self.scene.config.limit.as_ref()?.most;
        Some(LimitSearch { stepping: self.stepping, most })
    }

    /// The margin of the equilibrium at the end of some states, where the objective asks for it.
    pub(super) fn margin(
        &mut self,
        problem: &Problem,
        rest: &[Vec3],
        states: &Trajectory,
    ) -> Result<Option<Margin>, Rejected> {
        if self.limit.is_none() {
            return Ok(None);
        }
        let (Some(growing), Some(search)) = (self.growing(problem, rest), self.search()) else {
            return Ok(None);
        };
        let mut workspace = Workspace::new(&growing.held);
        if let Some(run) = &self.nearby
            && let Some(Margin { factor, at: Some(at) }) = &run.margin
            && let Some(other) = self.growing(&run.problem, &run.rest)
            && let Some(limit) = growing.next_to(&mut workspace, &search, (&other, *factor, at))
        {
            return Ok(Some(Margin::found(limit)));
        }
        let u = states.last();
        let at = problem.iterate(rest, &u, growing.time);
        let multipliers = solve_multipliers(problem, &mut self.workspace, &at);
        let end = Iterate { multipliers: &multipliers, ..at };
        let start = (&end, self.start.clone());
        match search.from(&growing.held, &mut workspace, start, |_| ()) {
            First::Found(limit, _) => Ok(Some(Margin::found(*limit))),
            First::None => Ok(Some(Margin { factor: search.most, at: None })),
            First::Between(_, [from, to]) => Err(self.reject(format!(
                "its limit lies between {from:.4} and {to:.4} times the pressure, but no state there was found"
            ))),
            First::Unstable => Err(self.reject("its equilibrium is not stable")),
            First::Lost(why) => {
                let why = why.map_or_else(|| "too many states".to_owned(), |why| why.to_string());
                Err(self.reject(format!("no limit was found on its path: {why}")))
            }
        }
    }

    /// Adds to dJ what the factor of the limit of a run counts in it.
    pub(super) fn add_limit(
        &self,
        run: &Run,
        factor: f64,
        gradient: &mut Gradient,
    ) -> Result<(), Rejected> {
        let Some((goal, weight)) = &self.limit else { return Ok(()) };
        let Some(Margin { factor: load, at: Some(at) }) = &run.margin else { return Ok(()) };
        let by_load = -2.0 * factor * weight * (goal.least - load).max(0.0);
        let (Some(growing), Some(search)) = (self.growing(&run.problem, &run.rest), self.search())
        else {
            return Ok(());
        };
        if by_load == 0.0 {
            return Ok(());
        }
        let mut workspace = Workspace::new(&growing.held);
        let state = growing.state(&mut workspace, *load, at);
        let limit = growing.near(&mut workspace, &search, (&state, at.kind));
        let limit = limit.ok_or_else(|| self.reject("its limit was not found again"))?;
        let Growing { held, chambers, rest, time } = &growing;
        let problem = &*run.problem;
        let grown = Grown { problem, held, rest, time: *time, growing: chambers };
        let by = grown.gradient(&mut workspace, &limit).map_err(|why| self.reject(why))?;
        gradient.rest.iter_mut().zip(&by.rest).for_each(|(sum, by)| *sum += by_load * by);
        for (id, by) in by.parameters.of_step(0) {
            let by = by.iter().map(|by| by_load * by).collect();
            gradient.parameters.add(run.states.steps() - 1, id, by);
        }
        Ok(())
    }
}
