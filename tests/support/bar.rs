//! A bar with three closed chambers, and its scene.

use std::collections::BTreeMap;

use mechanics::forward::{LoadStep, Problem, Solution, solve_in_time};
use mesh::Vec3;
use reports::Chamber;
use run::report::results;
use scene::Scene;

use crate::{block, tag};

/// The beginning of every scene.
const BODY: &str = r#"
mesh = "bar.msh"
degree = 2

[material]
kind = "mooney-rivlin"
c1 = 55e3
c2 = 5e3
c3 = 1.7e3
d1 = 1e6
"#;

/// A bar that is held at its root.
pub const HELD: &str = "[[fixed]]\non = \"root\"\n";

/// The equilibria of a scene.
pub struct Simulated {
    /// The scene.
    pub scene: Scene,
    /// Its discrete problem.
    pub problem: Problem,
    /// All accepted load steps.
    pub solution: Solution,
}

/// Solves the bar of 70 × 30 × 30 mm with cubic chambers `left`, `middle` and
/// `right`, and tags `root`, `end`, `top`, `skin`, under some loads.
pub fn simulate(loads: &str) -> Simulated {
    let folder = tempfile::tempdir().expect("a temporary folder");
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
    mesh::io::write_tets(&folder.path().join("bar.msh"), &body.mesh, &body.tags)
        .expect("a sound body");
    let path = folder.path().join("sim.toml");
    std::fs::write(&path, format!("{BODY}{loads}")).expect("the folder is writable");
    let scene = Scene::read(&path).unwrap_or_else(|e| panic!("{e:#}"));
    let (problem, mut workspace) = scene.problem(&scene.body).unwrap_or_else(|e| panic!("{e:#}"));
    let rest = scene.body.mesh.vertices.clone();
    let (stepping, times) = (scene.stepping(), scene.times());
    let solution = solve_in_time(&problem, &mut workspace, &rest, &stepping, &times, |_| ());
    let solution = solution.unwrap_or_else(|e| panic!("{e}"));
    Simulated { scene, problem, solution }
}

impl Simulated {
    /// The ends of time steps.
    pub fn ends(&self) -> Vec<LoadStep> {
        self.solution.steps.iter().filter(|s| s.ends_time_step).cloned().collect()
    }

    /// The chambers at a load step.
    pub fn chambers(&self, step: &LoadStep) -> BTreeMap<String, Chamber> {
        let at = step.iterate(&self.problem, &self.scene.body.mesh.vertices);
        results::chambers(&self.problem.energies, &at)
    }

    /// The chambers at the end.
    pub fn last_chambers(&self) -> BTreeMap<String, Chamber> {
        let last = self.ends().pop().expect("there is a step");
        self.chambers(&last)
    }
}

/// Largest difference of two fields relative to the largest value.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().chain(b).fold(0.0_f64, |m, x| m.max(x.abs()));
    let gap = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    gap / largest.max(f64::MIN_POSITIVE)
}
