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
use variables::DesignMap;
use variables::vectors::along;

use super::rest_path::RestPath;
use super::robust::Robust;
use super::scenario::{Near, Rejected, Run, Scenario};
use super::{shares, validity};

/// A design with its runs and objective.
#[derive(Clone)]
pub struct Evaluation {
    /// The design variables [m].
    pub theta: Vec<f64>,
    /// Rest vertex positions [m].
    pub rest: Vec<Vec3>,
    /// Run of each scenario.
    pub runs: Vec<Run>,
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

/// A design problem with a fixed mesh topology and fixed variables.
pub struct Level {
    /// The body at θ = 0.
    pub body: Body,
    /// From variables to rest shape and loads.
    pub map: DesignMap,
    /// The surface on the way to another shape.
    pub(super) path: RestPath,
    /// The scenarios; the scene itself where the design has none.
    pub scenarios: Vec<Scenario>,
    pub(super) robust: Robust,
    /// What the rest shape keeps to.
    pub(super) constraints: Vec<Constraint>,
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
        let edge = map.mean_edge;
        let configs = design.scenarios();
        let scenarios = configs.iter().map(|config| {
            let scenario = Scenario::new(config, scene, &body, edge, objectives, design, level);
            scenario.map_err(|error| match config.title() {
                None => error,
                Some(title) => error.context(title),
            })
        });
        let scenarios: Vec<Scenario> = scenarios.collect::<Result<_>>()?;
        check_memory(&scenarios)?;
        let (vertices, moving) = (body.mesh.vertices.len(), map.moving());
        let path = RestPath::new(vertices, body.boundary(), moving, map.mean_edge);
        let constraints = design.constraint.iter().map(|kept| kept.build(&body));
        let constraints: Vec<Option<Constraint>> = constraints.collect::<Result<_>>()?;
        let constraints = constraints.into_iter().flatten().collect();
        let robust = Robust::new(&configs, design.robust);
        Ok(Self { body, map, path, robust, scenarios, constraints })
    }

    /// Number of design variables.
    pub fn variables(&self) -> usize {
        self.map.variables()
    }

    /// The first of them.
    fn first(&self) -> &Scenario {
        &self.scenarios[0]
    }

    /// Whether the scene goes through time.
    pub fn is_transient(&self) -> bool {
        self.first().is_transient()
    }

    /// Names of the terms, in the order of the design file, and of [`EXCESS`], if there is one.
    pub fn term_names(&self) -> Vec<String> {
        let excess = (!self.robust.is_mean()).then_some(EXCESS);
        self.first().term_names().chain(excess).map(str::to_owned).collect()
    }

    /// Does the same for all scenarios, at the same time; the first error counts.
    fn each<T: Send>(
        &self,
        one: impl Fn(usize, &Scenario) -> Result<T, Rejected> + Sync,
    ) -> Result<Vec<T>, Rejected> {
        let all = self.scenarios.par_iter().enumerate();
        let one = |(i, scenario)| one(i, scenario).map_err(|rejected| rejected.by(i));
        let done: Vec<Result<T, Rejected>> = all.map(one).collect();
        done.into_iter().collect()
    }

    /// Shape, runs and objective at θ, with where the run of each scenario is looked for: from rest without any.
    pub fn evaluate(&self, theta: &[f64], near: &[Near]) -> Result<Evaluation, Rejected> {
        let clock = Instant::now();
        let rest = self.map.shape(theta);
        self.admit(&rest)?;
        let loads = self.map.load_variables(theta);
        let near = |i: usize| near.get(i).unwrap_or(&Near::Rest);
        let runs = self.each(|i, scenario| scenario.run(loads, &rest, near(i)))?;
        let forward_s = clock.elapsed().as_secs_f64();
        Ok(Evaluation { forward_s, ..self.evaluated(theta, rest, runs) })
    }

    /// An evaluation as it was, from the displacements of all scenarios at the ends of time
    /// steps, one scenario after the other [m].
    pub fn recall<E: Into<anyhow::Error>>(
        &self,
        theta: &[f64],
        displacements: impl Iterator<Item = Result<Vec<f64>, E>>,
    ) -> Result<Evaluation> {
        let (rest, loads) = (self.map.shape(theta), self.map.load_variables(theta));
        let times: Vec<f64> =
            self.scenarios.iter().flat_map(|scenario| &scenario.times).copied().collect();
        let states = self.states(theta, &times, displacements)?;
        let recall =
            |(i, states): (usize, Trajectory)| Ok(self.scenarios[i].recall(loads, &rest, states)?);
        let runs = states.into_iter().enumerate().map(recall).collect::<Result<_>>()?;
        Ok(self.evaluated(theta, rest, runs))
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
        let parts = self.robust.weights.clone();
        let all = self.each(|i, own| Ok(own.values(&at.runs[i], |_| true)))?;
        for (values, part) in all.into_iter().zip(parts) {
            means.iter_mut().zip(values).for_each(|(mean, value)| *mean += part * value);
        }
        self.set_weights(&shares::weights(&wanted, &means)?);
        let runs = self.each(|i, own| Ok(own.rated(&at.runs[i])))?;
        let Evaluation { theta, rest, newton_iterations, forward_s, .. } = at;
        Ok(Evaluation { newton_iterations, forward_s, ..self.evaluated(&theta, rest, runs) })
    }

    fn evaluated(&self, theta: &[f64], rest: Vec<Vec3>, runs: Vec<Run>) -> Evaluation {
        let objectives: Vec<f64> = runs.iter().map(|run| run.objective).collect();
        let mut objective = self.robust.value(&objectives);
        let mut terms = BTreeMap::new();
        for (run, weight) in runs.iter().zip(&self.robust.weights) {
            for (name, value) in &run.terms {
                *terms.entry(name.clone()).or_insert(0.0) += weight * value;
            }
        }
        if !self.robust.is_mean() {
            terms.insert(EXCESS.to_owned(), objective - self.robust.mean(&objectives));
        }
        for (name, _, [cost, ..]) in self.map.costs(theta) {
            objective += cost;
            terms.insert(name.to_owned(), cost);
        }
        let newton_iterations = runs.iter().map(|run| run.newton_iterations).sum();
        let theta = theta.to_vec();
        Evaluation { theta, rest, runs, objective, terms, newton_iterations, forward_s: 0.0 }
    }

    /// Where the runs of a changed scene are looked for: next to those of an evaluation.
    pub fn near(&self, at: &Evaluation) -> Vec<Near> {
        at.runs.iter().map(Run::near).collect()
    }

    /// Makes an evaluation ready for [`Self::gradient`], predictions and trials at or
    /// next to it. What follows depends on the evaluation alone, not on how it was reached: an interrupted search
    /// continues with the same bits.
    pub fn linearize(&self, at: &mut Evaluation) {
        let all = self.scenarios.par_iter().zip(&mut at.runs);
        all.for_each(|(scenario, run)| scenario.linearize(run));
    }

    /// The equilibria of a linearised evaluation changed to the shape X(θ), to first order. None where one is not stable.
    pub(super) fn predict(&self, theta: &[f64], at: &Evaluation) -> Option<Vec<Near>> {
        let shape = self.map.shape(theta);
        let one = |(scenario, run): (&Scenario, &Run)| {
            let change = scenario.predict(run, &shape)?;
            Some(Near::Displacement(along(&run.states.last(), &change, 1.0)))
        };
        self.scenarios.par_iter().zip(&at.runs).map(one).collect()
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
        self.runs(at).flat_map(one).collect()
    }

    /// Runs with the shape at θ that have been carried over to the mesh of this level
    /// ([`Self::carry`]).
    pub fn carried<E: Into<anyhow::Error>>(
        &self,
        theta: &[f64],
        times: &[f64],
        displacements: impl Iterator<Item = Result<Vec<f64>, E>>,
    ) -> Result<Vec<Near>> {
        let states = self.states(theta, times, displacements)?;
        Ok(states.into_iter().map(|states| Near::Carried(Arc::new(states))).collect())
    }

    /// States with the shape and the loads at θ, from displacements at times [m, s], one scenario after the other.
    fn states<E: Into<anyhow::Error>>(
        &self,
        theta: &[f64],
        times: &[f64],
        mut displacements: impl Iterator<Item = Result<Vec<f64>, E>>,
    ) -> Result<Vec<Trajectory>> {
        let rest = self.map.shape(theta);
        let loads = self.map.load_variables(theta);
        let each = times.len() / self.scenarios.len();
        let mut one = |(scenario, times): (&Scenario, &[f64])| {
            let states = times.iter().copied().zip(displacements.by_ref());
            scenario.states(loads, &rest, states)
        };
        self.scenarios.iter().zip(times.chunks(each)).map(&mut one).collect()
    }

    /// dJ/dθ at an evaluation, which is linearised.
    pub fn gradient(&self, at: &Evaluation) -> Result<Vec<f64>, Rejected> {
        let shape = self.map.shape_variables();
        let wanted = match at.theta.len() - shape {
            0 => Wanted::Shape,
            _ if shape == 0 => Wanted::Numbers,
            _ => Wanted::All,
        };
        let swept = self.sweep_for(at, wanted, None)?;
        let mut gradient = self.vjp(&at.theta, &swept);
        for (_, i, [_, slope, _]) in self.map.costs(&at.theta) {
            gradient[i] += slope;
        }
        Ok(gradient)
    }

    /// dJ of the objective, or of its terms of a name, by all that the run of each scenario
    /// depends on; their sum counts. Where the evaluation is linearised, that saves factorisations.
    pub fn sweep(&self, at: &Evaluation, of: Option<&str>) -> Result<Vec<Gradient>, Rejected> {
        self.sweep_for(at, Wanted::All, of)
    }

    fn sweep_for(
        &self,
        at: &Evaluation,
        wanted: Wanted,
        of: Option<&str>,
    ) -> Result<Vec<Gradient>, Rejected> {
        let objectives: Vec<f64> = at.runs.iter().map(|run| run.objective).collect();
        let (by, means) = (self.robust.derivatives(&objectives), &self.robust.weights);
        self.each(|i, scenario| {
            let (of, factor) = match of {
                None => (None, by[i]),
                Some(EXCESS) => (None, by[i] - means[i]),
                Some(_) => (of, means[i]),
            };
            scenario.sweep(&at.runs[i], &at.rest, wanted, (of, factor))
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

    /// The scenarios with the runs of an evaluation.
    pub fn runs<'a>(
        &'a self,
        at: &'a Evaluation,
    ) -> impl Iterator<Item = (&'a Scenario, &'a Run)> + Clone {
        self.scenarios.iter().zip(&at.runs)
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
}

/// Each has been checked alone; the factors of all are kept at the same time.
fn check_memory(scenarios: &[Scenario]) -> Result<()> {
    let need: Need = scenarios.iter().map(Scenario::memory).sum();
    let count = scenarios.len();
    memory::require(need).with_context(|| format!("{count} scenarios at the same time"))
}
