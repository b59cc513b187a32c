//! Bodies that move: a scene through time, step by step.

use mesh::{SurfaceMesh, Vec3};
use serde_json::Value;
use solver::body::Body;
use solver::forward::{LoadStep, March, System};
use solver::results;
use solver::scene::Scene;
use tempfile::TempDir;

/// The material of all scenes here, for a `[[body]]` or at the top.
pub const SILICONE: &str =
    "material = { kind = \"neo-hookean\", young = 1e5, poisson = 0.35, density = 1000.0 }\n";

/// A scene under way.
pub struct Motion {
    /// The scene.
    pub scene: Scene,
    /// Its discrete problem.
    pub system: System,
    /// How far it is.
    pub march: March,
    /// The last time step.
    pub last: Option<LoadStep>,
    /// The files of the scene, which reports read again.
    _folder: Option<TempDir>,
}

/// A scene of bodies `name.msh`, surfaces `name.stl` and text.
///
/// # Panics
/// When the scene is refused.
#[must_use]
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
    ///
    /// # Panics
    /// When it is refused.
    #[must_use]
    pub fn of(scene: Scene) -> Self {
        let system = scene.system(&scene.body).unwrap_or_else(|e| panic!("{e:#}"));
        let march = March::new(scene.stepping(), scene.integrator(&scene.body, &system));
        Self { scene, system, march, last: None, _folder: None }
    }

    /// Goes through the next `count` time steps.
    ///
    /// # Panics
    /// When there are fewer, or one is not reached.
    pub fn go(&mut self, count: usize) {
        let rest = self.scene.body.mesh.vertices.clone();
        for _ in 0..count {
            let now = self.march.progress.time;
            let next = self.scene.times().into_iter().find(|&t| t > now).expect("a time step");
            let mut last = None;
            self.march
                .advance(&mut self.system, &rest, next, |step| last = Some(step.clone()))
                .unwrap_or_else(|e| panic!("{e}"));
            self.last = last;
        }
    }

    /// Nodal displacements [m].
    #[must_use]
    pub fn u(&self) -> &[f64] {
        self.march.progress.reached()
    }

    /// Nodal velocities [m/s].
    #[must_use]
    pub fn v(&self) -> &[f64] {
        &self.march.progress.integrator.last().v
    }

    /// What `solver simulate` reports of the last step.
    ///
    /// # Panics
    /// Before the first step.
    pub fn report(&mut self) -> Value {
        let step = self.last.as_ref().expect("a step was made");
        let v = self.march.progress.integrator.last().v.clone();
        let v = self.march.progress.integrator.method.has_inertia().then_some(&v[..]);
        results::step(&self.scene, &self.scene.body, &mut self.system, step, v)
            .expect("tags are known")
    }

    /// ∫ ρ w dX of a nodal field over all bodies, e.g. momentum [kg m/s].
    #[must_use]
    pub fn momentum(&self, w: &[f64]) -> Vec3 {
        let rest = &self.scene.body.mesh.vertices;
        results::momentum(&self.system.energies, &self.system.space, rest, w)
    }
}
