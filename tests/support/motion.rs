//! Bodies that move: a scene through time, step by step.

use mechanics::body::Body;
use mechanics::forward::{LoadStep, Problem, TimeStepper, Workspace};
use mesh::{SurfaceMesh, Vec3};
use run::report::results;
use scene::Scene;
use serde_json::Value;
use tempfile::TempDir;

/// The material of all scenes here, for a `[[body]]` or at the top.
pub const SILICONE: &str =
    "material = { kind = \"neo-hookean\", young = 1e5, poisson = 0.35, density = 1000.0 }\n";

/// A run of a scene.
pub struct Motion {
    /// The scene.
    pub scene: Scene,
    /// Its discrete problem.
    pub problem: Problem,
    /// What solving it needs.
    pub workspace: Workspace,
    /// How far it is.
    pub stepper: TimeStepper,
    /// The last time step.
    pub last: Option<LoadStep>,
    /// The files of the scene, which reports read again.
    _folder: Option<TempDir>,
}

/// A scene of bodies `name.msh`, surfaces `name.stl` and text.
pub fn begin(bodies: &[(&str, &Body)], surfaces: &[(&str, &SurfaceMesh)], text: &str) -> Motion {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, body) in bodies {
        let path = folder.path().join(format!("{name}.msh"));
        mesh::io::write_tets(&path, &body.mesh, &body.tags).expect("a sound body");
    }
    for (name, surface) in surfaces {
        let path = folder.path().join(format!("{name}.stl"));
        mesh::io::write_surface(&path, surface).expect("a sound surface");
    }
    let path = folder.path().join("sim.toml");
    std::fs::write(&path, text).expect("the folder is writable");
    let scene = Scene::read(&path).unwrap_or_else(|e| panic!("{e:#}"));
    Motion { _folder: Some(folder), ..Motion::of(scene) }
}

impl Motion {
    /// A scene at t = 0.
    pub fn of(scene: Scene) -> Self {
        let (problem, workspace) = scene.problem(&scene.body).unwrap_or_else(|e| panic!("{e:#}"));
        let integrator = scene.integrator(&scene.body, &problem);
        let stepper = TimeStepper::new(scene.stepping(), integrator);
        Self { scene, problem, workspace, stepper, last: None, _folder: None }
    }

    /// Goes through the next `count` time steps.
    pub fn go(&mut self, count: usize) {
        let rest = self.scene.body.mesh.vertices.clone();
        for _ in 0..count {
            let now = self.stepper.progress.time;
            let next = self.scene.times().into_iter().find(|&t| t > now).expect("a time step");
            let mut last = None;
            self.stepper
                .advance(&self.problem, &mut self.workspace, &rest, next, |step| {
                    last = Some(step.clone())
                })
                .unwrap_or_else(|e| panic!("{e}"));
            self.last = last;
        }
    }

    /// Nodal displacements [m].
    pub fn u(&self) -> &[f64] {
        self.stepper.progress.reached()
    }

    /// Nodal velocities [m/s].
    pub fn v(&self) -> &[f64] {
        &self.stepper.progress.integrator.last().v
    }

    /// What `solver simulate` reports of the last step.
    pub fn report(&mut self) -> Value {
        let step = self.last.as_ref().expect("a step was made");
        let v = self.stepper.progress.integrator.last().v.clone();
        let v = self.stepper.progress.integrator.method.has_inertia().then_some(&v[..]);
        let measured = (&[][..], 0.0);
        let step = results::step(&self.scene, &self.scene.body, &self.problem, step, v, measured);
        serde_json::json!(step.expect("tags are known"))
    }

    /// ∫ ρ w dX of a nodal field over all bodies, e.g. momentum [kg m/s].
    pub fn momentum(&self, w: &[f64]) -> Vec3 {
        let rest = &self.scene.body.mesh.vertices;
        results::momentum(&self.problem.energies, &self.problem.space, rest, w)
    }
}
