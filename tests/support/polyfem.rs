//! Runs of PolyFEM on scenes that were published with Gjoka et al. 2024, and the
//! same scenes here.

use mesh::Vec3;
use serde_json::Value;
use solver::element::at;
use solver::import::{self, Options};
use solver::scene::Scene;

use crate::motion::Motion;
use crate::published::FOLDER;
use crate::shared;
use crate::workdir::Workdir;

/// What PolyFEM found.
pub struct Reference {
    /// Vertices of the first body that were looked at.
    pub vertices: Vec<usize>,
    /// Its time steps.
    pub steps: Vec<Probed>,
}

/// A time step of PolyFEM.
pub struct Probed {
    /// From 1.
    pub step: usize,
    /// Displacement of the vertices; no component along z in the plane [m].
    pub u: Vec<Vec3>,
    /// Largest displacement of all nodes [m].
    pub largest: f64,
}

/// A file of `../shared/reference`, where it is at hand.
///
/// # Panics
/// When it is there and cannot be read.
#[must_use]
pub fn reference(name: &str) -> Option<Reference> {
    let path = shared(&format!("reference/{name}.json"))?;
    let text = std::fs::read_to_string(path).expect("readable");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let ids = json["nodes"]["mesh_vertex_id_0based"].as_array().expect("ids");
    let id = |v: &Value| v.as_u64().and_then(|v| v.try_into().ok()).expect("an id");
    let steps = json["steps"].as_array().expect("steps").iter().filter_map(probed);
    Some(Reference { vertices: ids.iter().map(id).collect(), steps: steps.collect() })
}

/// None of the state at rest.
fn probed(step: &Value) -> Option<Probed> {
    let vector = |u: &Value| Vec3::from_fn(|k, _| u[k].as_f64().unwrap_or(0.0));
    Some(Probed {
        u: step["u_m"].as_array()?.iter().map(vector).collect(),
        step: step["step"].as_u64().and_then(|n| n.try_into().ok())?,
        largest: step["max_abs_u_m"].as_f64()?,
    })
}

/// A published scene, changed by `edit`, as imported, and the folder in which
/// it lies.
///
/// # Panics
/// When it is there and refused.
#[must_use]
pub fn scene(file: &str, options: &Options, edit: impl Fn(&mut Value)) -> Option<(Workdir, Scene)> {
    let path = shared(&format!("{FOLDER}/{file}"))?;
    let text = std::fs::read_to_string(&path).expect("readable");
    let mut json: Value = serde_json::from_str(&text).expect("JSON");
    // the files that it names stay where they are
    let folder = path.parent().expect("a file").canonicalize().expect("a folder");
    for body in json["geometry"].as_array_mut().expect("bodies") {
        for key in ["mesh", "surface_selection"] {
            if let Some(name) = body[key].as_str() {
                body[key] = Value::from(folder.join(name).to_string_lossy());
            }
        }
    }
    edit(&mut json);
    let dir = Workdir::new();
    dir.write("scene.json", &json.to_string());
    let imported = import::read(&dir.path("scene.json"), options);
    let imported = imported.unwrap_or_else(|e| panic!("{e:#}"));
    imported.write(&dir.path("")).expect("the folder is writable");
    let scene = Scene::read(&dir.path("sim.toml")).unwrap_or_else(|e| panic!("{e:#}"));
    Some((dir, scene))
}

/// Goes through the first `count` time steps; of those that the reference has,
/// the largest distance of a probe from it, over the largest displacement.
///
/// # Panics
/// When a step is not reached.
#[must_use]
pub fn differences(scene: Scene, reference: &Reference, count: usize) -> Vec<(usize, f64)> {
    let mut motion = Motion::of(scene);
    let mut all = Vec::new();
    for step in 1..=count {
        motion.go(1);
        let Some(theirs) = reference.steps.iter().find(|s| s.step == step) else { continue };
        let distance = |(&v, u): (&usize, &Vec3)| (at(motion.u(), v) - u).norm();
        let worst = reference.vertices.iter().zip(&theirs.u).map(distance).fold(0.0, f64::max);
        let relative = worst / theirs.largest;
        eprintln!("step {step}: off by {relative:.2e} of the largest displacement");
        all.push((step, relative));
    }
    all
}
