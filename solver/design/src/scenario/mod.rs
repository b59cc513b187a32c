//! One scenario of a level: rest shape and loads → run through time → objective, and the
//! derivatives of that by all that the run depends on.
//!
//! A [`Scenario`] is what does not change from one evaluation to the next, besides orders and factors of tangents, and a
//! [`Run`] what one evaluation has found.

mod bound;
mod changes;
mod runs;
mod slope;
mod terms;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::Result;
use mechanics::adjoint::Gradient;
use mechanics::body::Body;
use mechanics::element::{FunctionSpace, interpolate};
use mechanics::forward::{Integrator, Problem, Stepping, Unreached, Workspace};
use mechanics::memory::Need;
use mesh::Vec3;
use scene::config::{DesignConfig, LevelConfig, ScenarioConfig};
use scene::{ObjectiveBuilder, Scene, Weighted};
use variables::LoadMap;

pub use self::bound::Bound;
pub use self::changes::scene_of;
pub use self::runs::{Near, Run};
use super::validity;
use run::report::failure::Diagnosis;
use scene::number::{Swept, Walls};

/// A shape that was not accepted, and why.
#[derive(Debug, thiserror::Error)]
#[error("{why}")]
pub struct Rejected {
    /// Why.
    pub why: String,
    /// What has no equilibrium, if that is why.
    unreached: Option<Box<NotReached>>,
}

/// A time step of a scenario without an equilibrium.
struct NotReached {
    /// Index of the scenario.
    scenario: usize,
    problem: Arc<Problem>,
    unreached: Unreached,
}

impl std::fmt::Debug for NotReached {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.unreached.fmt(f)
    }
}

impl Rejected {
    /// For a reason.
    pub fn new(why: impl ToString) -> Self {
        Self { why: why.to_string(), unreached: None }
    }

    /// The same, by the scenario with this index.
    pub fn by(mut self, scenario: usize) -> Self {
        self.unreached.iter_mut().for_each(|unreached| unreached.scenario = scenario);
        self
    }

    /// Explains why there is no equilibrium, if that was sought through time.
    pub fn diagnose(&self, scenarios: &[Scenario]) -> Option<Diagnosis> {
        let NotReached { scenario, problem, unreached } = &**self.unreached.as_ref()?;
        let scenario = &scenarios[*scenario];
        let mut workspaces = scenario.workspaces();
        let solver = (&**problem, &mut workspaces.equilibrium);
        let mut body = scenario.body.clone();
        body.mesh.vertices = scenario.rest(&body.mesh.vertices);
        Some(Diagnosis::new(&scenario.scene, &body, solver, unreached))
    }
}

/// Orders and factors of tangents, kept from one evaluation to the next.
struct Workspaces {
    equilibrium: Workspace,
    /// Of the slope of the pressure, once there is one.
    slope: Option<Workspace>,
}

/// A scene with its changes, on a fixed mesh topology.
pub struct Scenario {
    /// As the design has it.
    pub config: ScenarioConfig,
    /// With its changes, but for walls.
    pub scene: Scene,
    /// Walls that are off.
    walls: Option<Walls>,
    loads: LoadMap,
    /// The body at the beginning of the level.
    body: Body,
    /// With the scene's own loads.
    pub problem: Problem,
    stepping: Stepping,
    /// The state at t = 0 and the time integration.
    start: Integrator,
    /// Ends of the time steps [s].
    pub times: Vec<f64>,
    /// Memory for the states of a run [B].
    state_memory: f64,
    terms: Vec<Weighted>,
    /// What the end of each run keeps.
    pub bounds: Vec<Bound>,
    workspaces: Mutex<Workspaces>,
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
        let (problem, equilibrium) = scene.problem(body)?;
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
        let loads = LoadMap::new(&scene, design, edge)?;
        Ok(Self {
            walls: changes::walls(config, &scene, body)?,
            loads,
            stepping: scene.stepping(),
            start: scene.integrator(body, &problem),
            times: scene.times(),
            state_memory: design.optimizer.state_memory / design.scenarios().len() as f64,
            terms,
            bounds,
            config: config.clone(),
            body: body.clone(),
            scene,
            problem,
            workspaces: Mutex::new(Workspaces { equilibrium, slope: None }),
        })
    }

    /// One computation after the other; what calls another one must not hold them.
    fn workspaces(&self) -> MutexGuard<'_, Workspaces> {
        self.workspaces.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What its solves need; those of a slope have a factor of their own.
    pub fn memory(&self) -> Need {
        let one = self.workspaces().equilibrium.memory();
        std::iter::once(one).chain(self.keeps_slope().then_some(one)).sum()
    }

    /// Whether the scene goes through time; else it is one equilibrium.
    pub fn is_transient(&self) -> bool {
        self.scene.config.time.is_some()
    }

    /// Names of the terms, in the order of the design file.
    pub fn term_names(&self) -> impl Iterator<Item = &str> {
        self.terms.iter().map(|term| term.name.as_str())
    }

    /// What messages begin with.
    fn reject(&self, why: impl ToString) -> Rejected {
        match self.config.title() {
            None => Rejected::new(why),
            Some(title) => Rejected::new(format!("{title}: {}", why.to_string())),
        }
    }

    /// Rest vertices with walls that are off, from those of the design [m].
    fn rest(&self, designed: &[Vec3]) -> Vec<Vec3> {
        match &self.walls {
            None => designed.to_vec(),
            Some(walls) => walls.moved(designed, &self.config.walls()),
        }
    }

    /// Whether a rest shape is valid, of which the design moves these facets, and every term admits it; cheap beside the
    /// equilibrium.
    pub fn admit(&self, designed: &[Vec3], moving: &[[usize; 3]]) -> Result<(), Rejected> {
        let rest = self.rest(designed);
        // where walls are off, all of them move
        let moving = self.walls.as_ref().map_or(moving, |_| self.body.boundary());
        validity::check(&rest, &self.body, moving).map_err(|e| self.reject(e))?;
        // a term without weight is none
        for term in self.terms.iter().filter(|term| term.weight * term.factor != 0.0) {
            let admitted = term.quantity.admit(&rest);
            admitted.map_err(|e| self.reject(format!("\"{}\": {e}", term.name)))?;
        }
        Ok(())
    }

    /// The problem with these variables of the loads.
    fn under(&self, loads: &[f64]) -> Result<Arc<Problem>, Rejected> {
        let problem = self.loads.problem(&self.problem, (&self.scene, &self.body), loads);
        problem.map(Arc::new).map_err(|why| self.reject(format!("{why:#}")))
    }

    /// The derivatives of a sweep, to be asked by the numbers of the scene.
    pub fn swept<'a>(&'a self, by: &'a Gradient) -> Swept<'a> {
        Swept::new(&self.scene, &self.problem, None, by)
    }

    /// The displacements of a run at the ends of time steps on another mesh of the same designed
    /// shape, by elements of another degree [m].
    pub fn carry(&self, run: &Run, designed: &[Vec3], body: &Body, degree: usize) -> Vec<Vec<f64>> {
        let vertices = &body.mesh.vertices;
        let other = FunctionSpace::new(degree, vertices.len(), body.mesh.tets.clone());
        interpolate(&run.problem.space, designed, &other, vertices, run.states.displacements())
    }
}
