//! Bodies that move: a scene through time, or to its load, step by step.

use std::collections::BTreeMap;

use mechanics::body::Body;
use mechanics::forward::{LoadStep, Problem, TimeStepper, Workspace};
use mesh::{SurfaceMesh, Vec3};
use reports::Chamber;
use run::report::results;
use scene::Scene;
use serde_json::Value;
use tempfile::TempDir;

use crate::{block, tag};

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

/// A bar that is held at its root.
pub const HELD: &str = "[[fixed]]\non = \"root\"\n";

/// A bar of 70 × 30 × 30 mm of degree 2 with closed cubic chambers `left`, `middle` and `right`, and tags `root`, `end`,
/// `top`, `skin`, under some loads.
pub fn bar(loads: &str) -> Motion {
    let mesh = block([7, 3, 3], 0.01, |c| c[1..] == [1, 1] && c[0] % 2 == 1, |p| p);
    let inside = |p: Vec3, x: f64| (p - Vec3::new(x, 0.015, 0.015)).amax() < 0.0055;
    let body = tag(
        mesh,
        &[
            ("root", &|p| p.x < 1e-9),
            ("end", &|p| p.x > 0.07 - 1e-9),
            ("top", &|p| p.z > 0.03 - 1e-9),
            ("left", &|p| inside(p, 0.015)),
            ("middle", &|p| inside(p, 0.035)),
            ("right", &|p| inside(p, 0.055)),
            ("skin", &|_| true),
        ],
    );
    let head = "mesh = \"bar.msh\"\ndegree = 2\n\n[material]\nkind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\n\
                d1 = 1e6\n";
    begin(&[("bar", &body)], &[], &format!("{head}{loads}"))
}

/// Largest difference of two fields relative to the largest value.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().chain(b).fold(0.0_f64, |m, x| m.max(x.abs()));
    let gap = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    gap / largest.max(f64::MIN_POSITIVE)
}

impl Motion {
    /// A scene at t = 0.
    pub fn of(scene: Scene) -> Self {
        let (problem, workspace) = scene.problem(&scene.body).unwrap_or_else(|e| panic!("{e:#}"));
        let integrator = scene.integrator(&scene.body, &problem);
        let stepper = TimeStepper::new(scene.stepping(), integrator);
        Self { scene, problem, workspace, stepper, last: None, _folder: None }
    }

    /// Goes through the next `count` time steps, in how many load steps.
    pub fn go(&mut self, count: usize) -> usize {
        let rest = self.scene.body.mesh.vertices.clone();
        let mut load_steps = 0;
        for _ in 0..count {
            let now = self.stepper.progress.time;
            let next = self.scene.times().into_iter().find(|&t| t > now).expect("a time step");
            let mut last = None;
            self.stepper
                .advance(&self.problem, &mut self.workspace, &rest, next, |step| {
                    load_steps += 1;
                    last = Some(step.clone());
                })
                .unwrap_or_else(|e| panic!("t = {next}: {e}"));
            self.last = last;
        }
        load_steps
    }

    /// Goes to the end: the states at the ends of time steps.
    pub fn ends(&mut self) -> Vec<LoadStep> {
        let count = self.scene.times().len();
        let mut end = || {
            self.go(1);
            self.last.clone().expect("a step was made")
        };
        (0..count).map(|_| end()).collect()
    }

    /// The chambers at the last time step.
    pub fn chambers(&self) -> BTreeMap<String, Chamber> {
        let at = self.stepper.iterate(&self.problem, &self.scene.body.mesh.vertices);
        results::chambers(&self.problem.energies, &at)
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

    /// Force of `contact` or `friction` by an obstacle on what touches it, at the last step [N].
    pub fn force_by(&mut self, obstacle: &str, kind: &str) -> Vec3 {
        let report = self.report();
        let all = report["collisions"][kind].as_array().expect("a list of forces");
        let own = all.iter().find(|force| force["bodies"][1] == obstacle).expect("it is touched");
        let force = own["force"].as_array().expect("a vector");
        Vec3::from_iterator(force.iter().map(|c| c.as_f64().expect("a number")))
    }

    /// Forces of contact on the nodes, at the last step [N].
    pub fn contact_field(&self) -> Vec<f64> {
        let at = self.stepper.iterate(&self.problem, &self.scene.body.mesh.vertices);
        let fields = results::grid_with_fields(&self.problem.energies, &at).point_fields;
        fields.into_iter().find(|f| f.name == "contact_force").expect("a scene with contact").values
    }

    /// ∫ ρ w dX of a nodal field over all bodies, e.g. momentum [kg m/s].
    pub fn momentum(&self, w: &[f64]) -> Vec3 {
        let rest = &self.scene.body.mesh.vertices;
        results::momentum(&self.problem.energies, &self.problem.space, rest, w)
    }
}
