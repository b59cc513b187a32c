//! The edges of a run as terms of the objective: the factor on the pressures at which the body balloons or buckles, that
//! at which its largest stretch is that at break, and the slope of the pressure, which needs no state beside the
//! equilibrium.
//!
//! w (least − t)₊²,   t the factor, at most that up to which a limit is sought, or the slope
//!
//! Factors: next to a run that is linearised they are sought by direct methods, from those there and their first-order change
//! with the rest shape; from a run that is not, or where they are not found so, along the path from the equilibrium on.
//!
//! A body may come to its limit before it bursts. Then the factor of the limit stands in for that of the burst. So the
//! factor is continuous, and so is its derivative at a limit point ([`Burst`]).

use std::ops::ControlFlow;
use std::sync::Arc;

use mechanics::adjoint::{Gradient, Grown};
use mechanics::energy::{ChamberId, Iterate};
use mechanics::forward::{
    Burst, BurstSearch, Configuration, Failure, First, Kind, Limit, LimitSearch, PressureSlope,
    Problem, Torn, Trajectory, Workspace, solve_multipliers,
};
use mechanics::stretch::LargestStretch;
use mesh::Vec3;
use scene::config::{BURST, LIMIT, SLOPE};
use serde::{Deserialize, Serialize};

use super::{Rejected, Run, Scenario};
use crate::study::limit::{beyond, configuration, growing};

/// Change of the factor from that of a nearby run, relative to it, above which it may be another one.
const NEARBY: f64 = 0.2;

/// A number that is to be large enough.
#[derive(Clone, Copy)]
pub(super) struct Edge {
    /// Name of its term, `LIMIT`, `BURST` or `SLOPE`.
    pub name: &'static str,
    /// The smallest one that is enough [1].
    pub least: f64,
    /// Whether it is a term of the objective; else it is kept.
    pub is_term: bool,
    /// Weight of its term in this scenario and level.
    pub weight: f64,
}

impl Edge {
    /// Whether it is a factor on the pressures.
    fn is_factor(&self) -> bool {
        self.name != SLOPE
    }

    /// How much a number counts in the objective.
    pub fn counts(&self, factor: f64) -> f64 {
        self.weight * (self.least - factor).max(0.0).powi(2)
    }

    /// The derivative of that; of one that is kept, the derivative of what is beyond `least`.
    fn slope(&self, factor: f64) -> f64 {
        if !self.is_term {
            return 1.0;
        }
        -2.0 * self.weight * (self.least - factor).max(0.0)
    }
}

/// How far a run is from an edge.
#[derive(Clone)]
pub struct Margin {
    /// Factor on the pressures there, or up to which there is none, or the slope [1].
    pub factor: f64,
    /// The state there, or that of the slope; none where it was not reached.
    pub(super) at: Option<Arc<AtEdge>>,
}

/// What is the matter with a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Singled {
    /// The load turns.
    LimitPoint,
    /// Another branch leaves.
    Bifurcation,
    /// The largest stretch is that at break.
    Burst,
    /// It is the equilibrium itself.
    End,
}

impl Singled {
    fn of(kind: Kind) -> Self {
        match kind {
            Kind::LimitPoint => Self::LimitPoint,
            Kind::Bifurcation => Self::Bifurcation,
        }
    }
}

/// The state at an edge.
pub(super) struct AtEdge {
    kind: Singled,
    /// Displacement [m].
    u: Vec<f64>,
}

/// What a checkpoint has of a margin; the displacement lies in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedMargin {
    factor: f64,
    kind: Option<Singled>,
}

impl Margin {
    /// What is kept beside the displacement.
    #[must_use]
    pub fn saved(&self) -> SavedMargin {
        SavedMargin { factor: self.factor, kind: self.at.as_ref().map(|at| at.kind) }
    }

    /// The displacement at the edge [m]; zeros where none was reached.
    #[must_use]
    pub fn displacement(&self, dofs: usize) -> Vec<f64> {
        self.at.as_ref().map_or_else(|| vec![0.0; dofs], |at| at.u.clone())
    }

    /// A margin as it was kept.
    #[must_use]
    pub fn of(saved: SavedMargin, u: Vec<f64>) -> Self {
        let at = saved.kind.map(|kind| Arc::new(AtEdge { kind, u }));
        Self { factor: saved.factor, at }
    }

    fn none_to(most: f64) -> Self {
        Self { factor: most, at: None }
    }

    fn limit(limit: &Limit) -> Self {
        let at = AtEdge { kind: Singled::of(limit.kind), u: limit.u.clone() };
        Self { factor: limit.load, at: Some(Arc::new(at)) }
    }

    fn slope(slope: &PressureSlope, u: Vec<f64>) -> Self {
        let at = AtEdge { kind: Singled::End, u };
        Self { factor: slope.value, at: Some(Arc::new(at)) }
    }

    fn burst(burst: Burst) -> Self {
        let Burst { load: factor, u, .. } = burst;
        Self { factor, at: Some(Arc::new(AtEdge { kind: Singled::Burst, u })) }
    }
}

/// The problem whose pressures grow, its end, and how its edges are found.
struct Growing<'a> {
    held: Problem,
    chambers: Vec<ChamberId>,
    rest: &'a [Vec3],
    time: f64,
    search: LimitSearch,
    at_break: Option<f64>,
}

impl<'a> Growing<'a> {
    /// The state at an edge of this problem.
    fn state(&self, workspace: &mut Workspace, factor: f64, at: &AtEdge) -> Configuration<'a> {
        let time = if at.kind == Singled::End { self.time } else { factor };
        let here = self.held.iterate(self.rest, &at.u, time);
        let multipliers = solve_multipliers(&self.held, workspace, &here);
        Configuration { rest: self.rest, time, step: None, u: at.u.clone(), multipliers }
    }

    /// The slope of the pressure at the equilibrium.
    fn slope(
        &self,
        workspace: &mut Workspace,
        end: &Configuration,
    ) -> Result<PressureSlope, Failure> {
        PressureSlope::of(&self.held, workspace, end, &self.chambers)
    }

    /// A limit by the direct method from a state.
    fn limit(
        &self,
        workspace: &mut Workspace,
        start: &Configuration,
        kind: Kind,
    ) -> Result<Limit, Failure> {
        Limit::near(&self.held, workspace, start, kind, &self.search.stepping.newton)
    }

    /// A burst by Newton's method from a state.
    fn burst(&self, workspace: &mut Workspace, start: &Configuration) -> Result<Burst, Failure> {
        let at_break = self.at_break.ok_or(Failure::Inadmissible)?;
        Burst::near(&self.held, workspace, start, at_break, &self.search.stepping.newton)
    }

    /// The edge of this rest shape next to that of a run with another one.
    fn next_to(
        &self,
        workspace: &mut Workspace,
        edge: &Edge,
        (other, factor, at): (&Growing, f64, &AtEdge),
    ) -> Option<Margin> {
        let found = match at.kind {
            Singled::LimitPoint => {
                self.next_limit(workspace, (other, factor, at), Kind::LimitPoint)
            }
            Singled::Bifurcation => {
                self.next_limit(workspace, (other, factor, at), Kind::Bifurcation)
            }
            Singled::Burst => self.next_burst(workspace, (other, factor, at)),
            Singled::End => None,
        }?;
        if at.kind != Singled::Burst && edge.name == BURST {
            // it may burst before that now
            let u = &found.at.as_ref()?.u;
            let stretch = LargestStretch::of(&self.held.space, self.rest, u).value;
            if self.at_break.is_none_or(|at_break| stretch >= at_break) {
                return None;
            }
        }
        ((found.factor / factor - 1.0).abs() < NEARBY).then_some(found)
    }

    fn next_limit(
        &self,
        workspace: &mut Workspace,
        (other, factor, at): (&Growing, f64, &AtEdge),
        kind: Kind,
    ) -> Option<Margin> {
        let there = other.state(workspace, factor, at);
        let moved = Limit::predicted(&other.held, workspace, &there, kind, &self.motion(other));
        let start = Configuration { rest: self.rest, ..moved.ok()? };
        let limit = self.limit(workspace, &start, kind).ok()?;
        (limit.others == 0 && limit.load > self.time).then(|| Margin::limit(&limit))
    }

    fn next_burst(
        &self,
        workspace: &mut Workspace,
        (other, factor, at): (&Growing, f64, &AtEdge),
    ) -> Option<Margin> {
        let there = other.state(workspace, factor, at);
        let moved = Burst::predicted(&other.held, workspace, &there, &self.motion(other));
        let start = Configuration { rest: self.rest, ..moved.ok()? };
        let burst = self.burst(workspace, &start).ok()?;
        (burst.negative == 0 && burst.load > 0.0).then(|| Margin::burst(burst))
    }

    fn motion(&self, other: &Growing) -> Vec<Vec3> {
        self.rest.iter().zip(other.rest).map(|(x, y)| x - y).collect()
    }

    /// The derivatives of the factor of a margin.
    fn gradient(
        &self,
        workspace: &mut Workspace,
        problem: &Problem,
        factor: f64,
        at: &AtEdge,
    ) -> Result<Gradient, Failure> {
        let Self { held, chambers, rest, time, .. } = self;
        let grown = Grown { problem, held, rest, time: *time, growing: chambers };
        let state = self.state(workspace, factor, at);
        let kind = match at.kind {
            Singled::LimitPoint => Kind::LimitPoint,
            Singled::Bifurcation => Kind::Bifurcation,
            Singled::Burst => {
                return Ok(grown.gradient_of_burst(&self.burst(workspace, &state)?));
            }
            Singled::End => {
                let slope = self.slope(workspace, &state)?;
                return grown.gradient_of_slope(workspace, &state, &slope);
            }
        };
        let limit = self.limit(workspace, &state, kind)?;
        grown.gradient(workspace, &limit)
    }
}

impl Scenario {
    fn growing<'a>(&self, problem: &Problem, rest: &'a [Vec3]) -> Option<Growing<'a>> {
        let (config, time) = (self.scene.config.limit.as_ref()?, self.times[0]);
        let chambers = growing(problem, config);
        let search = LimitSearch { stepping: self.stepping, most: config.most };
        let at_break = self.scene.stretch_at_break();
        let held = problem.held(time, &chambers);
        Some(Growing { held, chambers, rest, time, search, at_break })
    }

    /// The margins of the equilibrium at the end of some states, one for each edge that the objective counts.
    pub(super) fn margins(
        &mut self,
        problem: &Problem,
        rest: &[Vec3],
        states: &Trajectory,
    ) -> Result<Vec<Margin>, Rejected> {
        if self.edges.is_empty() {
            return Ok(Vec::new());
        }
        let Some(growing) = self.growing(problem, rest) else { return Ok(Vec::new()) };
        let mut workspace = Workspace::new(&growing.held);
        let u = states.last();
        let at = problem.iterate(rest, &u, growing.time);
        let multipliers = solve_multipliers(problem, &mut self.workspace, &at);
        let end = Iterate { multipliers: &multipliers, ..at };
        let mut margins = match self.factors().next() {
            None => Vec::new(),
            Some(_) => match self.margins_nearby(&growing, &mut workspace) {
                Some(found) => found,
                None => self.margins_on_path(&growing, &mut workspace, &end)?,
            },
        };
        if self.factors().count() < self.edges.len() {
            margins.push(self.margin_of_slope(&growing, &mut workspace, &end)?);
        }
        Ok(margins)
    }

    /// The edges that are factors, which come first.
    fn factors(&self) -> impl Iterator<Item = &Edge> {
        self.edges.iter().filter(|edge| edge.is_factor())
    }

    /// The margin of the slope at an equilibrium.
    fn margin_of_slope(
        &self,
        growing: &Growing,
        workspace: &mut Workspace,
        end: &Iterate,
    ) -> Result<Margin, Rejected> {
        let state = Configuration { rest: growing.rest, ..configuration(end) };
        let slope = growing
            .slope(workspace, &state)
            .map_err(|why| self.reject(format!("the pressure has no slope: {why}")))?;
        if slope.negative > 0 {
            return Err(self.reject("its equilibrium is not stable"));
        }
        Ok(Margin::slope(&slope, state.u))
    }

    /// The margins next to those of the run that was linearised.
    fn margins_nearby(&self, growing: &Growing, workspace: &mut Workspace) -> Option<Vec<Margin>> {
        let run = self.nearby.as_ref()?;
        let other = self.growing(&run.problem, &run.rest)?;
        let one = |(edge, Margin { factor, at }): (&Edge, &Margin)| {
            growing.next_to(workspace, edge, (&other, *factor, at.as_deref()?))
        };
        self.factors().zip(&run.margins).map(one).collect()
    }

    /// The margins along the path from an equilibrium on.
    fn margins_on_path(
        &self,
        growing: &Growing,
        workspace: &mut Workspace,
        end: &Iterate,
    ) -> Result<Vec<Margin>, Rejected> {
        let Growing { held, rest, search, .. } = growing;
        let bursts = self.edges.iter().any(|edge| edge.name == BURST);
        let at_break = growing.at_break.filter(|_| bursts);
        let mut way = at_break.map(|at_break| BurstSearch::new(end, at_break));
        let needs_limit = self.edges.iter().any(|edge| edge.name == LIMIT);
        let is_enough = |way: &Option<BurstSearch>| {
            !needs_limit && way.as_ref().is_some_and(BurstSearch::has_passed)
        };
        let first = if is_enough(&way) {
            First::Stopped
        } else {
            search.from(held, workspace, (end, self.start.clone()), |step| {
                if let Some(way) = &mut way {
                    way.pass(&step.iterate(held, rest));
                }
                if is_enough(&way) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        };
        if let (First::Found(limit, _), Some(way)) = (&first, &mut way) {
            let multipliers = &limit.multipliers;
            let at = held.iterate(rest, &limit.u, limit.load);
            way.pass(&Iterate { multipliers, ..at });
        }
        let torn =
            way.map_or(Torn::Never, |way| way.found(held, workspace, rest, &search.stepping));
        let mut torn = Some(torn);
        let of = |edge: &Edge| match torn.take_if(|_| edge.name == BURST) {
            None => self.at_first(&first, search.most),
            Some(torn) => self.at_burst(torn, &first, search.most),
        };
        self.factors().map(of).collect()
    }

    /// The margin of the first limit of a path.
    fn at_first(&self, first: &First, most: f64) -> Result<Margin, Rejected> {
        match first {
            First::Found(limit, _) => Ok(Margin::limit(limit)),
            First::None => Ok(Margin::none_to(most)),
            First::Between(_, [from, to]) => Err(self.reject(format!(
                "its limit lies between {from:.4} and {to:.4} times the pressure, but no state there was found"
            ))),
            First::Unstable => Err(self.reject("its equilibrium is not stable")),
            First::Stopped => Err(self.reject("its limit was not sought")),
            First::Lost(why) => {
                let why =
                    why.as_ref().map_or_else(|| "too many states".to_owned(), ToString::to_string);
                Err(self.reject(format!("no limit was found on its path: {why}")))
            }
        }
    }

    /// The margin of the burst, or of the limit that comes before it.
    fn at_burst(&self, torn: Torn, first: &First, most: f64) -> Result<Margin, Rejected> {
        match torn {
            Torn::At(burst) => Ok(Margin::burst(*burst)),
            Torn::Between([from, to]) => Err(self.reject(format!(
                "it reaches the stretch at break between {from:.4} and {to:.4} times the pressure, but no state there \
                 was found"
            ))),
            Torn::Beyond(why) => Err(self.reject(beyond(why.as_ref()))),
            Torn::Never => {
                if let First::Found(limit, _) = first {
                    log::info!(
                        "it reaches its limit, at {:.3} × the pressure, before the stretch at break: \"{BURST}\" counts \
                         that factor",
                        limit.load
                    );
                }
                self.at_first(first, most)
            }
        }
    }

    /// Adds to dJ what the factors of the edges of a run count in it, of all terms or of one.
    pub(super) fn add_edges(
        &self,
        run: &Run,
        of: Option<&str>,
        factor: f64,
        gradient: &mut Gradient,
    ) -> Result<(), Rejected> {
        for (edge, margin) in self.edges.iter().zip(&run.margins) {
            if of.map_or(!edge.is_term, |name| name != edge.name) {
                continue;
            }
            let Margin { factor: load, at: Some(at) } = margin else { continue };
            let by_load = factor * edge.slope(*load);
            if by_load == 0.0 {
                continue;
            }
            let Some(growing) = self.growing(&run.problem, &run.rest) else { continue };
            let mut workspace = Workspace::new(&growing.held);
            let by = growing.gradient(&mut workspace, &run.problem, *load, at).map_err(|why| {
                self.reject(format!("the state of \"{}\" was not found again: {why}", edge.name))
            })?;
            gradient.rest.iter_mut().zip(&by.rest).for_each(|(sum, by)| *sum += by_load * by);
            for (id, by) in by.parameters.of_step(0) {
                let by = by.iter().map(|by| by_load * by).collect();
                gradient.parameters.add(run.states.steps() - 1, id, by);
            }
        }
        Ok(())
    }
}
