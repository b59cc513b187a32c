//! One level of the cascade: variables θ → rest shape and loads → the runs of all scenarios →
//! objective, and the gradient of that whole map.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use measure::constraint::Constraint;
use mechanics::adjoint::{Gradient, Wanted};
use mechanics::body::Body;
use mechanics::forward::Trajectory;
use mechanics::math::linear::sum;
use mechanics::memory::Need;
use mesh::Vec3;
use rayon::prelude::*;
use scene::config::{DesignConfig, EXCESS, LevelConfig, ObjectiveConfig, Weight};
use scene::memory;
use scene::{ObjectiveBuilder, Scene};

use super::costs::Costs;
use super::rest_path::RestPath;
use super::robust::Robust;
use super::scenario::{Near, Rejected, Run, Scenario, Workspaces};
use super::vectors::along;
use super::{shares, validity};
use crate::variables::DesignMap;
use run::report::crossing::Crossing;
use run::report::failure::Diagnosis;

/// A design with its runs and objective.
#[derive(Clone)]
pub struct Evaluation {
    /// Rest vertex positions [m].
    pub rest: Vec<Vec3>,
    /// Run of each scenario.
    pub runs: Vec<Run>,
    /// Variables of the loads [m].
    loads: Vec<f64>,
    /// What is minimised, the sum of the terms.
    pub objective: f64,
    /// Mean over the scenarios of each weighted term, by the user's name, and [`EXCESS`], where
    /// the objective is not the mean.
    pub terms: BTreeMap<String, f64>,
    /// Newton iterations of all runs.
    pub newton_iterations: usize,
    /// Time for the shape, its runs and the terms [s].
    pub forward_s: f64,
}

impl Evaluation {
    /// Gives up the tangents of its runs, so that there is memory for those of others.
    pub fn forget_tangents(&mut self) {
        self.runs.iter_mut().for_each(|run| run.tangents = Arc::default());
    }
}

/// Where runs are looked for.
#[derive(Clone, Copy)]
pub enum Start<'a> {
    /// From rest.
    Rest,
    /// Equilibria of a scene without time next to displacements [m], one for each scenario.
    Next(&'a [Vec<f64>]),
    /// From rest through time, next to the runs of another evaluation.
    Guided(&'a [Run]),
    /// From rest through time, next to states that were foreseen from the runs of another evaluation.
    Foreseen(&'a [Arc<Trajectory>], &'a [Run]),
    /// Next to runs that were carried over from another mesh.
    Carried(&'a [Arc<Trajectory>]),
}

impl<'a> Start<'a> {
    fn of(self, scenario: usize) -> Near<'a> {
        match self {
            Self::Rest => Near::Rest,
            Self::Next(displacements) => Near::Displacement(&displacements[scenario]),
            Self::Guided(runs) => Near::Run(&runs[scenario].states, &runs[scenario].tangents),
            Self::Foreseen(all, runs) => Near::Run(&all[scenario], &runs[scenario].tangents),
            Self::Carried(runs) => Near::Carried(&runs[scenario]),
        }
    }
}

/// A design problem with a fixed mesh topology and fixed variables.
pub struct Level {
    /// The body at θ = 0.
    pub body: Body,
    pub(super) map: DesignMap,
    /// The surface on the way to another shape.
    pub(super) path: RestPath,
    pub(super) scenarios: Vec<Scenario>,
    /// Of each scenario.
    pub(super) workspaces: Vec<Workspaces>,
    pub(super) robust: Robust,
    pub(super) constraints: Vec<Constraint>,
    pub(super) costs: Costs,
}

impl Level {
    /// Sets up a level on a body.
    pub fn new(
        scene: &Scene,
        objectives: &ObjectiveBuilder,
        body: Body,
        design: &DesignConfig,
        level: &LevelConfig,
    ) -> Result<Self> {
        let map = DesignMap::new(scene, design, level, &body)?;
        let edge = map.mean_edge();
        let configs = design.scenarios();
        let scenarios = configs.iter().map(|config| {
            let scenario = Scenario::new(config, scene, &body, edge, objectives, design, level);
            scenario.map_err(|error| match config.title() {
                None => error,
                Some(title) => error.context(title),
            })
        });
        let scenarios: Vec<(Scenario, Workspaces)> = scenarios.collect::<Result<_>>()?;
        check_memory(&scenarios)?;
        let (scenarios, workspaces) = scenarios.into_iter().unzip();
        let (vertices, moving) = (body.mesh.vertices.len(), map.moving());
        let path = RestPath::new(vertices, body.boundary(), moving, map.mean_edge());
        let constraints = design.constraint.iter().map(|kept| kept.build(&body));
        let constraints: Vec<Option<Constraint>> = constraints.collect::<Result<_>>()?;
        let constraints = constraints.into_iter().flatten().collect();
        let robust = Robust::new(&configs, design.robust);
        let costs = Costs::new(&design.parameter, &map);
        Ok(Self { body, map, path, robust, scenarios, workspaces, constraints, costs })
    }

    /// Number of design variables.
    pub fn variables(&self) -> usize {
        self.map.variables()
    }

    /// What the rest shape keeps to.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// From variables to rest shape and loads.
    pub fn map(&self) -> &DesignMap {
        &self.map
    }

    /// The scenarios; the scene itself where the design has none.
    pub fn scenarios(&self) -> &[Scenario] {
        &self.scenarios
    }

    /// The first of them.
    fn first(&self) -> &Scenario {
        &self.scenarios[0]
    }

    /// Number of degrees of freedom of an equilibrium.
    pub fn dofs(&self) -> usize {
        self.first().problem().dofs()
    }

    /// Whether the scene goes through time.
    pub fn is_transient(&self) -> bool {
        self.first().is_transient()
    }

    /// Number of time steps.
    pub fn steps(&self) -> usize {
        self.first().steps()
    }

    /// Names of the terms, in the order of the design file, and of [`EXCESS`], if there is one.
    pub fn term_names(&self) -> Vec<String> {
        let excess = (!self.robust.is_mean()).then_some(EXCESS);
        self.first().term_names().chain(excess).map(str::to_owned).collect()
    }

    /// Does the same for all scenarios, at the same time; the first error counts.
    fn each<T: Send>(
        &mut self,
        one: impl Fn(usize, &Scenario, &mut Workspaces) -> Result<T, Rejected> + Sync,
    ) -> Result<Vec<T>, Rejected> {
        let all = self.scenarios.par_iter().zip(&mut self.workspaces).enumerate();
        let one = |(i, (scenario, workspaces))| {
            one(i, scenario, workspaces).map_err(|rejected| rejected.by(i))
        };
        let done: Vec<Result<T, Rejected>> = all.map(one).collect();
        done.into_iter().collect()
    }

    /// Shape, runs and objective at θ.
    pub fn evaluate(&mut self, theta: &[f64], start: Start) -> Result<Evaluation, Rejected> {
        let clock = Instant::now();
        let rest = self.map.shape(theta);
        self.admit(&rest)?;
        let loads = self.map.load_variables(theta).to_vec();
        let runs = self
            .each(|i, scenario, workspaces| scenario.run(workspaces, &loads, &rest, start.of(i)))?;
        let forward_s = clock.elapsed().as_secs_f64();
        Ok(Evaluation { forward_s, ..self.evaluated(rest, runs, loads) })
    }

    /// An evaluation as it was, from the displacements of all scenarios at the ends of time
    /// steps, one scenario after the other [m].
    pub fn recall<E: Into<anyhow::Error>>(
        &mut self,
        theta: &[f64],
        mut displacements: impl Iterator<Item = Result<Vec<f64>, E>>,
    ) -> Result<Evaluation> {
        let rest = self.map.shape(theta);
        let (loads, steps) = (self.map.load_variables(theta).to_vec(), self.steps());
        let mut runs = Vec::new();
        for (scenario, workspaces) in self.scenarios.iter().zip(&mut self.workspaces) {
            let states: Vec<_> = displacements.by_ref().take(steps).collect();
            runs.push(scenario.recall(workspaces, &loads, &rest, states.into_iter())?);
        }
        Ok(Evaluation { newton_iterations: 0, ..self.evaluated(rest, runs, loads) })
    }

    /// Factors of the terms, in the order of the design file.
    pub fn weights(&self) -> Vec<f64> {
        self.first().weights()
    }

    /// Gives the terms these factors in all scenarios.
    pub fn set_weights(&mut self, weights: &[f64]) {
        self.scenarios.iter_mut().for_each(|scenario| scenario.set_weights(weights));
    }

    /// Gives the terms the shares that they are to have at an evaluation,
    /// and the evaluation with the new weights.
    pub fn weigh(&mut self, terms: &[ObjectiveConfig], at: Evaluation) -> Result<Evaluation> {
        let wanted: Vec<_> = terms.iter().map(|term| (term.name(), term.weight())).collect();
        if wanted.iter().all(|(_, weight)| matches!(weight, Weight::Factor(_))) {
            return Ok(at);
        }
        let mut means = vec![0.0; wanted.len()];
        let parts = self.robust.weights().to_vec();
        let all =
            self.each(|i, own, workspaces| Ok(own.values(workspaces, &at.runs[i], |_| true)))?;
        for (values, part) in all.into_iter().zip(parts) {
            means.iter_mut().zip(values).for_each(|(mean, value)| *mean += part * value);
        }
        self.set_weights(&shares::weights(&wanted, &means)?);
        let runs = self.each(|i, own, workspaces| Ok(own.rated(workspaces, &at.runs[i])))?;
        let Evaluation { rest, newton_iterations, forward_s, loads, .. } = at;
        Ok(Evaluation { newton_iterations, forward_s, ..self.evaluated(rest, runs, loads) })
    }

    fn evaluated(&self, rest: Vec<Vec3>, runs: Vec<Run>, loads: Vec<f64>) -> Evaluation {
        let objectives: Vec<f64> = runs.iter().map(|run| run.objective).collect();
        let mut objective = self.robust.value(&objectives);
        let mut terms = BTreeMap::new();
        for (run, weight) in runs.iter().zip(self.robust.weights()) {
            for (name, value) in &run.terms {
                *terms.entry(name.clone()).or_insert(0.0) += weight * value;
            }
        }
        if !self.robust.is_mean() {
            terms.insert(EXCESS.to_owned(), objective - self.robust.mean(&objectives));
        }
        for (name, cost) in self.costs.values(&loads) {
            objective += cost;
            terms.insert(name, cost);
        }
        let newton_iterations = runs.iter().map(|run| run.newton_iterations).sum();
        Evaluation { rest, runs, loads, objective, terms, newton_iterations, forward_s: 0.0 }
    }

    /// What a trial looks for next to an evaluation: the displacements that were predicted for
    /// the equilibria of a scene without time, else the whole runs.
    pub fn near<'a>(&self, at: &'a Evaluation, predicted: &'a [Vec<f64>]) -> Start<'a> {
        if self.is_transient() { Start::Guided(&at.runs) } else { Start::Next(predicted) }
    }

    /// Explains why the body at θ = 0 was rejected, if it has no equilibrium.
    pub fn diagnose(&mut self, rejected: &Rejected) -> Option<Diagnosis> {
        rejected.diagnose(&self.scenarios, &mut self.workspaces)
    }

    /// Makes an evaluation ready for [`Self::gradient`], [`Self::predict`] and trials at or
    /// next to it. What follows depends on the evaluation alone, not on how it was reached: an interrupted search
    /// continues with the same bits.
    pub fn linearize(&mut self, at: &mut Evaluation) {
        let all = self.scenarios.par_iter().zip(&mut self.workspaces).zip(&mut at.runs);
        all.for_each(|((scenario, workspaces), run)| scenario.linearize(workspaces, run));
    }

    /// First-order change of the equilibria of a linearised evaluation to the shape X(θ): a start for
    /// [`Self::evaluate`] along this step. None where an equilibrium is not stable, or of a run through time.
    pub fn predict(&mut self, theta: &[f64], at: &Evaluation) -> Option<Vec<Vec<f64>>> {
        let shape = self.map.shape(theta);
        let all = self.scenarios.par_iter().zip(&mut self.workspaces).zip(&at.runs);
        all.map(|((scenario, workspaces), run)| scenario.predict(workspaces, run, &shape)).collect()
    }

    /// The body with the rest shape of an evaluation.
    pub fn shape(&self, at: &Evaluation) -> Body {
        let mut body = self.body.clone();
        body.mesh.vertices.clone_from(&at.rest);
        body
    }

    /// The displacements of an evaluation on another mesh of the same shape, by elements
    /// of another degree [m], and their times [s], one scenario after the other.
    pub fn carry(&self, at: &Evaluation, body: &Body, degree: usize) -> Vec<(f64, Vec<f64>)> {
        let one = |(scenario, run): (&Scenario, &Run)| {
            let carried = scenario.carry(run, &at.rest, body, degree);
            run.states.times[1..].iter().copied().zip(carried).collect::<Vec<_>>()
        };
        self.scenarios.iter().zip(&at.runs).flat_map(one).collect()
    }

    /// Runs with the shape at θ that have been carried over to the mesh of this level
    /// ([`Self::carry`]).
    pub fn carried<E: Into<anyhow::Error>>(
        &self,
        theta: &[f64],
        times: &[f64],
        mut displacements: impl Iterator<Item = Result<Vec<f64>, E>>,
    ) -> Result<Vec<Arc<Trajectory>>> {
        let rest = self.map.shape(theta);
        let loads = self.map.load_variables(theta);
        let each = times.len() / self.scenarios.len();
        let mut one = |(scenario, times): (&Scenario, &[f64])| {
            let states = times.iter().copied().zip(displacements.by_ref());
            scenario.states(loads, &rest, states).map(Arc::new)
        };
        self.scenarios.iter().zip(times.chunks(each)).map(&mut one).collect()
    }

    /// dJ/dθ at an evaluation made with the same θ, which is linearised.
    pub fn gradient(&mut self, theta: &[f64], at: &Evaluation) -> Result<Vec<f64>, Rejected> {
        let shape = self.map.shape_variables();
        let wanted = match theta.len() - shape {
            0 => Wanted::Shape,
            _ if shape == 0 => Wanted::Numbers,
            _ => Wanted::All,
        };
        let swept = self.sweep_for(at, wanted, None)?;
        let mut gradient = self.vjp(theta, &swept);
        for (i, slope) in self.costs.slopes(&at.loads) {
            gradient[shape + i] += slope;
        }
        Ok(gradient)
    }

    /// dJ of the objective, or of its terms of a name, by all that the run of each scenario
    /// depends on; their sum counts. Where the evaluation is linearised, that saves factorisations.
    pub fn sweep(&mut self, at: &Evaluation, of: Option<&str>) -> Result<Vec<Gradient>, Rejected> {
        self.sweep_for(at, Wanted::All, of)
    }

    fn sweep_for(
        &mut self,
        at: &Evaluation,
        wanted: Wanted,
        of: Option<&str>,
    ) -> Result<Vec<Gradient>, Rejected> {
        let objectives: Vec<f64> = at.runs.iter().map(|run| run.objective).collect();
        let (by, means) = (self.robust.derivatives(&objectives), self.robust.weights().to_vec());
        self.each(|i, scenario, workspaces| {
            let (of, factor) = match of {
                None => (None, by[i]),
                Some(EXCESS) => (None, by[i] - means[i]),
                Some(_) => (of, means[i]),
            };
            scenario.sweep(workspaces, &at.runs[i], &at.rest, wanted, (of, factor))
        })
    }

    /// dJ/dθ from what was swept at θ.
    pub fn vjp(&self, theta: &[f64], swept: &[Gradient]) -> Vec<f64> {
        let mut gradient = self.map.vjp(theta, &sum(swept.iter().map(|by| &by.rest)));
        let loads = self.map.load_variables(theta);
        let by_loads = self.scenarios.iter().zip(swept);
        let by_loads = by_loads.map(|(scenario, by)| scenario.by_loads(loads, by));
        gradient.extend(sum(by_loads));
        gradient
    }

    /// Mean displacement of each tag over its rest area in each scenario [m].
    pub fn mean_displacements(&self, at: &Evaluation) -> Result<Vec<BTreeMap<String, f64>>> {
        let pairs = self.scenarios.iter().zip(&at.runs);
        pairs.map(|(scenario, run)| scenario.mean_displacements(run)).collect()
    }

    /// The probes of the scene in each scenario, in the units of their kinds.
    pub fn measured(&self, at: &Evaluation) -> Result<Vec<BTreeMap<String, f64>>> {
        let pairs = self.scenarios.iter().zip(&at.runs);
        pairs.map(|(scenario, run)| scenario.measured(run)).collect()
    }

    /// The fraction of the step from θ to θ + d on which the boundary of the rest shape
    /// does not intersect itself.
    pub fn free_fraction(&self, theta: &[f64], d: &[f64]) -> f64 {
        if self.map.moving().is_empty() {
            return 1.0;
        }
        self.path.free(|t| self.map.surface(&along(theta, d, t)))
    }

    /// Whether a rest shape is valid in all scenarios and every term admits it; cheap beside
    /// the equilibria.
    pub fn admit(&self, rest: &[Vec3]) -> Result<(), Rejected> {
        let moving = self.map.moving();
        self.scenarios.iter().try_for_each(|scenario| scenario.admit(rest, moving))
    }

    /// Whether the rest shape at θ has no elements that are too flat for a trial.
    pub fn check_flat(&self, theta: &[f64]) -> Result<(), Rejected> {
        let tets = &self.body.mesh.tets;
        let least = validity::smallest_of_trials(&self.body.mesh.vertices, tets);
        let found = validity::check_volumes(&self.map.shape(theta), tets, least);
        found.map_err(Rejected::new)
    }

    /// Surfaces that have passed through each other at the end of a scenario.
    pub fn crossing(&self, at: &Evaluation) -> Option<Crossing> {
        let mut all = self.scenarios.iter().zip(&at.runs);
        all.find_map(|(scenario, run)| scenario.crossing(run))
    }
}

/// Each has been checked alone; the factors of all are kept at the same time.
fn check_memory(scenarios: &[(Scenario, Workspaces)]) -> Result<()> {
    let need: Need = scenarios.iter().map(|(own, workspaces)| own.memory(workspaces)).sum();
    let count = scenarios.len();
    memory::require(need).with_context(|| format!("{count} scenarios at the same time"))
}
