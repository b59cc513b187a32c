//! One scenario of a level: rest shape and loads → run through time → objective, and the
//! derivatives of that by all that the run depends on.

mod bound;
mod changes;
mod curvature;
mod gradient;
mod run;
mod slope;
mod solve;
mod terms;

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::Result;
use measure::probe::measure;
use mechanics::adjoint::Gradient;
use mechanics::body::Body;
use mechanics::element::{FunctionSpace, interpolate};
use mechanics::forward::{
    Integrator, Linearizations, Problem, Stepping, Trajectory, Unreached, Workspace, follow,
};
use mechanics::memory::Need;
use mesh::Vec3;
use scene::config::{DesignConfig, LevelConfig, ScenarioConfig};
use scene::{ObjectiveBuilder, Scene, Weighted};

pub use self::bound::Bound;
pub use self::changes::scene_of;
pub use self::run::Run;
use super::offset::Offset;
use super::validity;
use crate::design::LoadMap;
use crate::report::crossing::Crossing;
use crate::report::failure::Diagnosis;
use crate::report::results::{displacements, grid_with_fields};
use scene::number::Swept;

/// Part of the memory that states leave which factors of tangents may take.
const FOR_TANGENTS: f64 = 0.25;

/// A shape that was not accepted, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Rejected(pub String);

/// Where a run is looked for.
#[derive(Clone, Copy)]
pub enum Near<'a> {
    /// From rest.
    Rest,
    /// The one equilibrium of a scene without time, next to a displacement [m]: keeps a
    /// search on one branch of equilibria, and is several times cheaper.
    Displacement(&'a [f64]),
    /// From rest through time, next to the states of another run.
    Run(&'a Arc<Trajectory>),
    /// From rest through time, next to the states of a run on another mesh, with the patience of a
    /// run from rest; without time, the one equilibrium next to the end of that run.
    Carried(&'a Arc<Trajectory>),
}

/// A scene with its changes, on a fixed mesh topology.
pub struct Scenario {
    /// As the design has it.
    pub config: ScenarioConfig,
    /// With its changes, but for walls.
    pub scene: Scene,
    offset: Option<Offset>,
    loads: LoadMap,
    /// Topology and tags of the body that it is on.
    body: Body,
    /// With the scene's own loads.
    problem: Problem,
    workspace: Workspace,
    /// Where it was linearised last: at the ends of these states.
    linearized: Option<(Arc<Trajectory>, Arc<Linearizations>)>,
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
    /// What its end keeps.
    bounds: Vec<Bound>,
    /// What the last slope of the pressure was solved with.
    growing: Option<Workspace>,
    /// What the last solve from rest did not reach, if it failed, and why.
    unreached: Option<(Arc<Problem>, Unreached)>,
}

impl Scenario {
    /// Sets up a scenario of a level on a body, whose moving surface has edges of about `edge`
    /// [m].
    pub fn new(
        config: &ScenarioConfig,
        scene: &Scene,
        body: &Body,
        edge: f64,
        objectives: &ObjectiveBuilder,
        design: &DesignConfig,
        level: &LevelConfig,
    ) -> Result<Self> {
        let scene = changes::under(scene, config)?;
        let (problem, workspace) = scene.problem(body)?;
        let mut terms = objectives.build(&scene, body, &problem.space)?;
        let factor = |name: &str| {
            let of = |weights: &BTreeMap<String, f64>| weights.get(name).copied().unwrap_or(1.0);
            of(&level.weights) * of(&config.weights)
        };
        terms.iter_mut().for_each(|term| term.factor = factor(&term.name));
        for kept in design.constraint.iter().filter(|kept| kept.slope().is_some()) {
            scene.config.check_slope(&kept.title())?;
        }
        let bounds = Bound::all(design, &scene, body, &problem)?;
        let (chambers, parameters) = (&design.chamber, &design.parameter);
        let loads = LoadMap::new(&scene, chambers, parameters, edge)?;
        Ok(Self {
            offset: Offset::new(config, body)?,
            loads,
            stepping: scene.stepping(),
            start: scene.integrator(body, &problem),
            times: scene.times(),
            state_memory: design.optimizer.state_memory / design.scenarios().len() as f64,
            transient: scene.config.time.is_some(),
            terms,
            bounds,
            growing: None,
            unreached: None,
            linearized: None,
            config: config.clone(),
            body: body.clone(),
            scene,
            problem,
            workspace,
        })
    }

    /// The discrete problem.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// What its solves need; those of a slope have a factor of their own.
    pub fn memory(&self) -> Need {
        let one = self.workspace.memory();
        std::iter::once(one).chain(self.bounds.iter().any(Bound::is_slope).then_some(one)).sum()
    }

    /// Whether the scene goes through time.
    pub fn is_transient(&self) -> bool {
        self.transient
    }

    /// Number of time steps.
    pub fn steps(&self) -> usize {
        self.times.len()
    }

    /// Names of the terms, in the order of the design file.
    pub fn term_names(&self) -> impl Iterator<Item = &str> {
        self.terms.iter().map(|term| term.name.as_str())
    }

    /// What the end of each run keeps.
    pub fn bounds(&self) -> &[Bound] {
        &self.bounds
    }

    /// What messages begin with.
    fn reject(&self, why: impl ToString) -> Rejected {
        match self.config.title() {
            None => Rejected(why.to_string()),
            Some(title) => Rejected(format!("{title}: {}", why.to_string())),
        }
    }

    /// Rest vertices with walls that are off, from those of the design [m].
    fn rest(&self, designed: &[Vec3]) -> Vec<Vec3> {
        match &self.offset {
            None => designed.to_vec(),
            Some(offset) => offset.apply(designed),
        }
    }

    /// Whether a rest shape of a body is valid, of which the design moves these facets, and
    /// every term admits it; cheap beside the equilibrium.
    pub fn admit(
        &self,
        designed: &[Vec3],
        body: &Body,
        moving: &[[usize; 3]],
    ) -> Result<(), Rejected> {
        let rest = self.rest(designed);
        // where walls are off, all of them move
        let moving = self.offset.as_ref().map_or(moving, |_| body.boundary());
        validity::check(&rest, body, moving).map_err(|e| self.reject(e))?;
        // a term without weight is none
        for term in self.terms.iter().filter(|term| term.weight * term.factor != 0.0) {
            let admitted = term.quantity.admit(&rest);
            admitted.map_err(|e| self.reject(format!("\"{}\": {e}", term.name)))?;
        }
        Ok(())
    }

    /// The run on a designed rest shape, with these variables of the loads.
    pub fn run(&mut self, loads: &[f64], designed: &[Vec3], near: Near) -> Result<Run, Rejected> {
        let (rest, problem) = (self.rest(designed), self.under(loads)?);
        let guided = |guide: &Arc<Trajectory>| Some(Arc::clone(guide));
        let (states, newton_iterations) = match near {
            Near::Displacement(u) => self.solve_next_to(&problem, &rest, u)?,
            Near::Carried(guide) if !self.transient => {
                self.solve_next_to(&problem, &rest, &guide.last())?
            }
            Near::Run(guide) => self.solve(&problem, &rest, guided(guide), self.nearby())?,
            Near::Carried(guide) => self.solve(&problem, &rest, guided(guide), self.patient())?,
            Near::Rest => self.solve(&problem, &rest, None, self.patient())?,
        };
        let slope = self.slope(&problem, &rest, &states)?;
        Ok(self.evaluated(problem, rest, (states, slope), newton_iterations))
    }

    /// A run as it was, from its displacements at the ends of time steps [m].
    pub fn recall<E: Into<anyhow::Error>>(
        &mut self,
        loads: &[f64],
        designed: &[Vec3],
        displacements: impl Iterator<Item = Result<Vec<f64>, E>>,
    ) -> Result<Run> {
        let times = self.times.clone().into_iter();
        let states = self.states(loads, designed, times.zip(displacements))?;
        let (problem, rest) = (self.under(loads)?, self.rest(designed));
        let slope = self.slope(&problem, &rest, &states)?;
        Ok(self.evaluated(problem, rest, (states, slope), 0))
    }

    /// States with displacements at times [s, m], as those of a run.
    pub fn states<E: Into<anyhow::Error>>(
        &self,
        loads: &[f64],
        designed: &[Vec3],
        displacements: impl Iterator<Item = (f64, Result<Vec<f64>, E>)>,
    ) -> Result<Trajectory> {
        let (rest, problem) = (self.rest(designed), self.under(loads)?);
        let mut states = Trajectory::begin(&self.start, self.state_memory);
        for (end, u) in displacements {
            states.push_displacement(&problem, &rest, end, &u.map_err(Into::into)?);
        }
        Ok(states)
    }

    /// The problem with these variables of the loads.
    fn under(&self, loads: &[f64]) -> Result<Arc<Problem>, Rejected> {
        let problem = self.loads.problem(&self.problem, (&self.scene, &self.body), loads);
        problem.map(Arc::new).map_err(|why| self.reject(format!("{why:#}")))
    }

    fn evaluated(
        &mut self,
        problem: Arc<Problem>,
        rest: Vec<Vec3>,
        (states, slope): (Trajectory, Option<f64>),
        newton_iterations: usize,
    ) -> Run {
        let (states, terms) = (Arc::new(states), BTreeMap::new());
        let kept = Vec::new();
        let objective = 0.0;
        let run = Run { problem, rest, states, slope, objective, terms, kept, newton_iterations };
        self.rated(&run)
    }

    /// The derivatives of a sweep, to be asked by the numbers of the scene.
    pub fn swept<'a>(&'a self, by: &'a Gradient) -> Swept<'a> {
        Swept::new(&self.scene, &self.problem, None, by)
    }

    /// Explains why a body has no equilibrium, after [`Self::run`] has sought it from rest in
    /// vain.
    pub fn diagnose(&mut self, body: &Body) -> Option<Diagnosis> {
        let (problem, unreached) = self.unreached.take()?;
        let mut body = body.clone();
        body.mesh.vertices = self.rest(&body.mesh.vertices);
        let solver = (&*problem, &mut self.workspace);
        Some(Diagnosis::new(&self.scene, &body, solver, &unreached))
    }

    /// Makes ready for [`Self::sweep`], [`Self::curvature`], [`Self::predict`] and runs at or next to a run. What follows
    /// depends on that run alone, not on how it was reached: an interrupted search continues with the same bits.
    pub fn linearize(&mut self, run: &Run) {
        self.linearized = None;
        let Run { problem, rest, states, .. } = run;
        let known = if !self.transient {
            Linearizations::at_end(problem, &mut self.workspace, rest, states)
        } else if problem.energies.contact_terms().next().is_none() {
            let memory = FOR_TANGENTS * states.memory_left();
            Linearizations::of(problem, &mut self.workspace, rest, states, memory)
        } else {
            // contact changes the pattern from one time step to the next
            return;
        };
        self.linearized = Some((Arc::clone(states), Arc::new(known)));
    }

    /// First-order change of the equilibrium of a run, where it is linearised, to another
    /// designed shape. None where the equilibrium is not stable, or of a run through time.
    pub fn predict(&mut self, run: &Run, designed: &[Vec3]) -> Option<Vec<f64>> {
        let rest = self.rest(designed);
        let motion: Vec<Vec3> = rest.iter().zip(&run.rest).map(|(a, b)| a - b).collect();
        if self.transient {
            return None;
        }
        let known = run.linearized(self.linearized.as_ref());
        follow(&run.problem, &mut self.workspace, known.step(1)?, &run.rest, &motion)
    }

    /// The displacements of a run at the ends of time steps on another mesh of the same designed
    /// shape, by elements of another degree [m].
    pub fn carry(&self, run: &Run, designed: &[Vec3], body: &Body, degree: usize) -> Vec<Vec<f64>> {
        let space = &*run.problem.space;
        let vertices = &body.mesh.vertices;
        let other = FunctionSpace::new(degree, vertices.len(), body.mesh.tets.clone());
        interpolate(space, designed, &other, vertices, run.states.displacements())
    }

    /// Mean displacement of each tag over its rest area [m].
    pub fn mean_displacements(&self, run: &Run, body: &Body) -> Result<BTreeMap<String, f64>> {
        let mut body = body.clone();
        body.mesh.vertices.clone_from(&run.rest);
        let one = |name: &String| {
            let facets = body.facets(name)?;
            let report = displacements(&body, &run.problem.space, &facets, &run.states.last());
            Ok((name.clone(), report.mean_displacement))
        };
        body.used_tags().map(one).collect()
    }

    /// The probes of the scene at the end of a run, in the units of their kinds, and the slope of the pressure, where it is kept.
    pub fn measured(&self, run: &Run, body: &Body) -> Result<BTreeMap<String, f64>> {
        let mut body = body.clone();
        body.mesh.vertices.clone_from(&run.rest);
        let probes = self.scene.probes(&body, &run.problem.space)?;
        let mut found = run.at_end(|end| measure(&probes, &run.problem, end));
        found.extend(run.slope.map(|slope| ("slope".to_owned(), slope)));
        Ok(found)
    }

    /// The solution's grid for ParaView, at the end of a run.
    pub fn grid(&self, run: &Run) -> mesh::io::vtu::Grid {
        run.at_end(|end| grid_with_fields(&run.problem.energies, end))
    }

    /// Surfaces of the body that have passed through each other at the end of a run.
    pub fn crossing(&self, run: &Run, body: &Body) -> Option<Crossing> {
        run.at_end(|end| Crossing::find(&self.scene, body, &run.problem, end))
    }
}
