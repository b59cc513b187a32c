//! One level of the cascade: variables θ → rest shape and loads → run through
//! time → objective, and the gradient of that whole map.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use mesh::Vec3;

use super::rest_path::RestPath;
use super::validity;
use crate::adjoint::{self, Gradient};
use crate::body::Body;
use crate::config::{DesignConfig, LevelConfig};
use crate::design::DesignMap;
use crate::element::{FunctionSpace, interpolate};
use crate::energy::Iterate;
use crate::forward::{
    Configuration, Integrator, Linearization, Newton, Problem, Stepping, TimeStepper, Trajectory,
    Unreached, Workspace, follow, solve_from, solve_multipliers,
};
use crate::objective::{Equilibrium, Objective};
use crate::report::failure::Diagnosis;
use crate::report::results::displacements;
use crate::scene::{ObjectiveBuilder, Scene, Weighted, nodes_of};

/// Newton iterations from a nearby equilibrium. Accepted shapes of the frog
/// took 2 to 8; what takes more is better reached by a shorter step.
const NEARBY: usize = 12;
/// The same in a load step of a run next to another, where bodies hit each other: simulated
/// from rest, the worm took at most 22, the gripper 11.
const NEARBY_IN_TIME: usize = 30;
/// Smallest load step of such a run, as a fraction of a time step.
const NEARBY_INCREMENT: f64 = 0.25;

/// A shape that was not accepted, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Rejected(pub String);

/// A design with its run and objective.
#[derive(Clone)]
pub struct Evaluation {
    /// Rest vertex positions [m].
    pub rest: Vec<Vec3>,
    /// All states.
    pub run: Arc<Trajectory>,
    /// Σ of the terms.
    pub objective: f64,
    /// Weighted value of each term, by the user's name.
    pub terms: BTreeMap<String, f64>,
    /// Newton iterations of the run.
    pub newton_iterations: usize,
    /// Time for the shape, its run and the terms [s].
    pub forward_s: f64,
}

/// Where a run is looked for.
#[derive(Clone, Copy)]
pub enum Start<'a> {
    /// From rest.
    Rest,
    /// Of a scene without time the one equilibrium, next to a displacement [m]: keeps a
    /// search on one branch of equilibria, and is several times cheaper.
    Next(&'a [f64]),
    /// From rest through time, next to the states of another run.
    Guided(&'a Arc<Trajectory>),
}

/// Forces on the nodes at a moment [N], three components per node; empty where no term looks at
/// them.
struct Forces {
    /// Of contact and friction.
    contact: Vec<f64>,
    /// Of supports.
    reaction: Vec<f64>,
}

/// A design problem with a fixed mesh topology and fixed variables.
pub struct Level {
    /// The body at θ = 0.
    pub body: Body,
    map: DesignMap,
    path: RestPath,
    problem: Problem,
    workspace: Workspace,
    /// Where the level was linearised last.
    linearization: Option<Linearization>,
    stepping: Stepping,
    /// The state at t = 0 and the time integration.
    start: Integrator,
    /// Ends of the time steps [s].
    times: Vec<f64>,
    /// Memory for the states of a run [B].
    state_memory: f64,
    /// Whether the scene goes through time; else it is one equilibrium.
    transient: bool,
    terms: Vec<Weighted>,
    /// Why the last solve from rest failed, if it did.
    unreached: Option<Unreached>,
}

impl Level {
    /// Sets up a level on a body.
    ///
    /// # Errors
    /// When a tag is missing or the handles cannot be placed.
    pub fn new(
        scene: &Scene,
        objectives: &ObjectiveBuilder,
        body: Body,
        design: &DesignConfig,
        level: &LevelConfig,
    ) -> Result<Self> {
        let (problem, workspace) = scene.problem(&body)?;
        let mut terms = objectives.build(scene, &body, &problem.space)?;
        for term in &mut terms {
            term.weight *= level.weights.get(term.objective.name()).unwrap_or(&1.0);
        }
        let map = DesignMap::new(scene, design, level, &body, &problem.energies)?;
        let (vertices, moving) = (body.mesh.vertices.len(), map.moving());
        let path = RestPath::new(vertices, body.boundary(), moving, map.mean_edge());
        Ok(Self {
            map,
            path,
            stepping: scene.stepping(),
            start: scene.integrator(&body, &problem),
            times: scene.times(),
            state_memory: design.optimizer.state_memory,
            transient: scene.config.time.is_some(),
            terms,
            unreached: None,
            body,
            problem,
            workspace,
            linearization: None,
        })
    }

    /// Number of design variables.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.map.variables()
    }

    /// From variables to rest shape and loads.
    #[must_use]
    pub fn map(&self) -> &DesignMap {
        &self.map
    }

    /// Number of degrees of freedom of the equilibrium.
    #[must_use]
    pub fn dofs(&self) -> usize {
        self.problem.dofs()
    }

    /// Whether the scene goes through time.
    #[must_use]
    pub fn is_transient(&self) -> bool {
        self.transient
    }

    /// Number of time steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.times.len()
    }

    /// Names of the terms, in the order of the design file.
    #[must_use]
    pub fn term_names(&self) -> Vec<String> {
        self.terms.iter().map(|t| t.objective.name().to_owned()).collect()
    }

    /// Shape, run and objective at θ.
    ///
    /// # Errors
    /// [`Rejected`] when the shape is invalid, a term is infinite or there is
    /// no equilibrium.
    pub fn evaluate(&mut self, theta: &[f64], start: Start) -> Result<Evaluation, Rejected> {
        let clock = Instant::now();
        let rest = self.map.shape(theta);
        self.admit(&rest)?;
        self.map.set_loads(theta, &mut self.problem.energies);
        let (run, newton_iterations) = match start {
            Start::Next(u) => self.run_next_to(&rest, u)?,
            Start::Guided(guide) => self.run(&rest, Some(Arc::clone(guide)))?,
            Start::Rest => self.run(&rest, None)?,
        };
        let (terms, run) = (self.terms_of(&rest, &run), Arc::new(run));
        let objective: f64 = terms.values().sum();
        let forward_s = clock.elapsed().as_secs_f64();
        Ok(Evaluation { rest, run, objective, terms, newton_iterations, forward_s })
    }

    /// The run from rest.
    fn run(
        &mut self,
        rest: &[Vec3],
        guide: Option<Arc<Trajectory>>,
    ) -> Result<(Trajectory, usize), Rejected> {
        let mut stepping = self.stepping;
        if guide.is_some() {
            stepping.newton.iterations = stepping.newton.iterations.min(NEARBY_IN_TIME);
            stepping.smallest = stepping.smallest.max(NEARBY_INCREMENT);
        }
        let mut stepper = TimeStepper::new(stepping, self.start.clone()).guided(guide);
        let mut run = Trajectory::begin(&self.start, self.state_memory);
        for &end in &self.times {
            let workspace = &mut self.workspace;
            let outcome = stepper.advance(&self.problem, workspace, rest, end, |_| ());
            if let Err(unreached) = outcome {
                let rejected = Rejected(unreached.to_string());
                self.unreached = Some(unreached);
                return Err(rejected);
            }
            run.push(end, stepper.progress.integrator.last().clone());
        }
        Ok((run, stepper.progress.newton_iterations))
    }

    /// The one equilibrium next to a displacement.
    fn run_next_to(&mut self, rest: &[Vec3], u: &[f64]) -> Result<(Trajectory, usize), Rejected> {
        let load = self.times[0];
        let step = Arc::new(self.one_step(u).step(&self.problem, rest, 1));
        let at = Iterate { step: Some(&step), ..self.problem.iterate(rest, u, load) };
        let multipliers = solve_multipliers(&self.problem, &mut self.workspace, &at);
        let start = Configuration { rest, load, step: Some(&step), u: u.to_vec(), multipliers };
        let newton = Newton { iterations: NEARBY, ..self.stepping.newton };
        let solution = solve_from(&self.problem, &mut self.workspace, &start, &newton)
            .map_err(|e| Rejected(e.to_string()))?;
        Ok((self.one_step(&solution.u), solution.newton_iterations))
    }

    /// An evaluation as it was, from its displacements at the ends of time steps [m].
    ///
    /// # Errors
    /// When one of them cannot be read.
    pub fn recall<E>(
        &mut self,
        theta: &[f64],
        displacements: impl Iterator<Item = Result<Vec<f64>, E>>,
    ) -> Result<Evaluation, E> {
        self.map.set_loads(theta, &mut self.problem.energies);
        let rest = self.map.shape(theta);
        let mut run = Trajectory::begin(&self.start, self.state_memory);
        for (&end, u) in self.times.iter().zip(displacements) {
            run.push_displacement(end, &u?);
        }
        let (terms, run) = (self.terms_of(&rest, &run), Arc::new(run));
        let objective: f64 = terms.values().sum();
        Ok(Evaluation { rest, run, objective, terms, newton_iterations: 0, forward_s: 0.0 })
    }

    /// What a trial looks for next to an evaluation: the displacement that was
    /// predicted for the equilibrium of a scene without time, else the whole run.
    #[must_use]
    pub fn near<'a>(&self, at: &'a Evaluation, predicted: &'a [f64]) -> Start<'a> {
        if self.transient { Start::Guided(&at.run) } else { Start::Next(predicted) }
    }

    /// The run to a displacement in one step.
    fn one_step(&self, u: &[f64]) -> Trajectory {
        let mut run = Trajectory::begin(&self.start, self.state_memory);
        run.push_displacement(self.times[0], u);
        run
    }

    /// Weighted terms over a run, by the user's names.
    fn terms_of(&mut self, rest: &[Vec3], run: &Trajectory) -> BTreeMap<String, f64> {
        let mut terms = BTreeMap::new();
        for n in 0..=run.steps() {
            let Forces { contact, reaction } = self.forces(rest, run, n);
            let (state, load) = (run.state(n), run.times[n]);
            let (space, u) = (&*self.problem.space, &state.u[..]);
            let at = Equilibrium { space, rest, u, load, contact: &contact, reaction: &reaction };
            for term in &self.terms {
                let value = match term.weight * term.factors[n] {
                    0.0 => 0.0,
                    factor => factor * term.objective.value(&at),
                };
                *terms.entry(term.objective.name().to_owned()).or_insert(0.0) += value;
            }
        }
        terms
    }

    /// Forces on the nodes at a moment, where a term looks at them; at t = 0 there are none.
    fn forces(&mut self, rest: &[Vec3], run: &Trajectory, n: usize) -> Forces {
        let looks = |uses: fn(&dyn Objective) -> bool| {
            self.terms.iter().any(|t| t.factors[n] != 0.0 && uses(&*t.objective))
        };
        let (uses_contact, uses_reaction) =
            (looks(|o| o.uses_contact()), looks(|o| o.uses_reaction()));
        let none = |wanted: bool| if wanted { vec![0.0; self.problem.dofs()] } else { Vec::new() };
        let mut forces = Forces { contact: none(uses_contact), reaction: none(uses_reaction) };
        if n == 0 || !uses_contact && !uses_reaction {
            return forces;
        }
        let (state, step) = (run.state(n), run.step(&self.problem, rest, n));
        let at = self.problem.iterate(rest, &state.u, run.times[n]);
        let at = Iterate { step: Some(&step), ..at };
        if uses_contact {
            forces.contact = self.problem.energies.contact_forces(&at);
        }
        if uses_reaction {
            let multipliers = solve_multipliers(&self.problem, &mut self.workspace, &at);
            let at = Iterate { multipliers: &multipliers, ..at };
            forces.reaction = self.problem.gradient(&at).0;
        }
        forces
    }

    /// dJ by the velocity of a body at t = 0, from that by all nodes' velocities.
    #[must_use]
    pub fn by_velocity(&self, part: usize, by_nodes: &[f64]) -> [f64; 3] {
        let mut sum = Vec3::zeros();
        for node in nodes_of(&self.body, part, &self.problem.space) {
            for k in (0..3).filter(|k| !self.problem.dirichlet.fixed()[3 * node + k]) {
                sum[k] += by_nodes[3 * node + k];
            }
        }
        sum.into()
    }

    /// Explains why the body at θ = 0 has no equilibrium, after
    /// [`Self::evaluate`] has sought it from rest in vain.
    pub fn diagnose(&mut self, scene: &Scene) -> Option<Diagnosis> {
        let unreached = self.unreached.take()?;
        let solver = (&self.problem, &mut self.workspace);
        Some(Diagnosis::new(scene, &self.body, solver, &unreached))
    }

    /// Makes ready for [`Self::gradient`], [`Self::predict`] and trials at or
    /// next to an evaluation of a scene without time. What follows depends on the
    /// evaluation alone, not on how it was reached: an interrupted search continues
    /// with the same bits.
    pub fn linearize(&mut self, theta: &[f64], at: &Evaluation) {
        self.map.set_loads(theta, &mut self.problem.energies);
        self.linearization = None;
        if !self.transient {
            let (step, u) = (at.run.step(&self.problem, &at.rest, 1), at.run.last());
            let here = Iterate { step: Some(&step), ..self.problem.iterate(&at.rest, &u, 1.0) };
            let multipliers = solve_multipliers(&self.problem, &mut self.workspace, &here);
            let here = Iterate { multipliers: &multipliers, ..here };
            self.linearization = Some(self.workspace.linearize(&self.problem, &here));
        }
    }

    /// First-order change of the equilibrium from `at`, where the level is
    /// linearised, to the shape X(θ): a start for [`Self::evaluate`] along this step.
    /// None where the equilibrium is not stable, or of a run through time.
    pub fn predict(&mut self, theta: &[f64], at: &Evaluation) -> Option<Vec<f64>> {
        let linearization = self.linearization.as_ref()?;
        let shape = self.map.shape(theta);
        let motion: Vec<Vec3> = shape.iter().zip(&at.rest).map(|(a, b)| a - b).collect();
        follow(&self.problem, &mut self.workspace, linearization, &at.rest, &motion)
    }

    /// The last displacement of an evaluation on another mesh of the same shape, by elements
    /// of another degree.
    #[must_use]
    pub fn carry(&self, at: &Evaluation, body: &Body, degree: usize) -> Vec<f64> {
        let space = &*self.problem.space;
        let vertices = &body.mesh.vertices;
        let other = FunctionSpace::new(degree, vertices.len(), body.mesh.tets.clone());
        interpolate((space, &at.rest, &at.run.last()), (&other, vertices))
    }

    /// dJ/dθ at an evaluation made with the same θ, where the level is
    /// linearised.
    ///
    /// # Errors
    /// When the adjoint system has no accurate solution.
    pub fn gradient(&mut self, theta: &[f64], at: &Evaluation) -> Result<Vec<f64>, Rejected> {
        let all: Vec<usize> = (0..self.terms.len()).collect();
        let gradient = self.sweep(at, &all)?;
        Ok(self.map.pull_back(theta, &gradient.rest, &gradient.parameters))
    }

    /// dJ of some of the terms by all that a run depends on. Where the level is
    /// linearised at the evaluation, that saves a factorisation.
    ///
    /// # Errors
    /// When the adjoint system has no accurate solution.
    pub fn sweep(&mut self, at: &Evaluation, terms: &[usize]) -> Result<Gradient, Rejected> {
        let forces: Vec<Forces> =
            (0..=at.run.steps()).map(|n| self.forces(&at.rest, &at.run, n)).collect();
        let mut by_rest = vec![0.0; 3 * at.rest.len()];
        let partials = |space: &FunctionSpace, n: usize, out: &mut adjoint::Partials| {
            let state = at.run.state(n);
            let (rest, load) = (&at.rest[..], at.run.times[n]);
            let (u, Forces { contact, reaction }) = (&state.u[..], &forces[n]);
            let here = Equilibrium { space, rest, u, load, contact, reaction };
            for term in terms.iter().map(|&i| &self.terms[i]) {
                let factor = term.weight * term.factors[n];
                if factor != 0.0 {
                    term.objective.add_du(&here, factor, &mut out.by_u);
                    term.objective.add_dcontact(&here, factor, &mut out.by_contact);
                    term.objective.add_dreaction(&here, factor, &mut out.by_reaction);
                    term.objective.add_drest(&here, factor, &mut by_rest);
                }
            }
        };
        let (problem, workspace) = (&self.problem, &mut self.workspace);
        let linearization = self.linearization.as_ref();
        let on = (&at.rest[..], &*at.run);
        let swept = adjoint::sweep(problem, workspace, on, linearization, partials);
        let mut gradient = swept.map_err(|e| Rejected(e.to_string()))?;
        gradient.rest.iter_mut().zip(&by_rest).for_each(|(g, b)| *g += b);
        for plane in &self.body.planes {
            // no shape moves them there
            plane.vertices().iter().for_each(|v| gradient.rest[3 * v + plane.axis] = 0.0);
        }
        Ok(gradient)
    }

    /// Mean displacement of each tag over its rest area [m].
    ///
    /// # Errors
    /// When a tag has no facets.
    pub fn mean_displacements(&self, at: &Evaluation) -> Result<BTreeMap<String, f64>> {
        let mut body = self.body.clone();
        body.mesh.vertices.clone_from(&at.rest);
        let one = |name: &String| {
            let facets = body.facets(name)?;
            let report = displacements(&body, &self.problem.space, &facets, &at.run.last());
            Ok((name.clone(), report.mean_displacement))
        };
        body.used_tags().map(one).collect()
    }

    /// The fraction of the step from θ to θ + d on which the boundary of the rest shape
    /// does not intersect itself.
    #[must_use]
    pub fn free_fraction(&self, theta: &[f64], d: &[f64]) -> f64 {
        if self.map.moving().is_empty() {
            return 1.0;
        }
        let at = |t: f64| -> Vec<f64> { theta.iter().zip(d).map(|(x, d)| x + t * d).collect() };
        self.path.free(|t| self.map.surface(&at(t)))
    }

    /// Whether a rest shape is valid and every term admits it; cheap beside the
    /// equilibrium.
    ///
    /// # Errors
    /// With the element, facet or term that is not valid.
    pub fn admit(&self, rest: &[Vec3]) -> Result<(), Rejected> {
        validity::check(rest, &self.body, self.map.moving())
            .map_err(|e| Rejected(e.to_string()))?;
        for term in &self.terms {
            let name = term.objective.name();
            term.objective.admit(rest).map_err(|e| Rejected(format!("\"{name}\": {e}")))?;
        }
        Ok(())
    }

    /// The solution's grid for ParaView.
    #[must_use]
    pub fn grid(&self, at: &Evaluation) -> mesh::io::vtu::Grid {
        crate::report::results::grid(&self.problem.space, &at.rest, &at.run.last())
    }
}
