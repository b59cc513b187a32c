//! Runs of PolyFEM on scenes that were published with Gjoka et al. 2024, and the
//! same scenes here.

use mechanics::element::at;
use mesh::Vec3;
use polyfem::{self, Options};
use scene::Scene;
use serde_json::Value;

use crate::motion::Motion;
use crate::published::FOLDER;
use crate::shared;
use crate::workdir::Workdir;

/// What PolyFEM found.
pub struct Reference {
    /// Vertices of the first body that are compared.
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
    /// Elastic energy of all bodies, to six digits [J]; in the plane per depth [J/m].
    pub elastic: f64,
    /// How the first body touches others.
    pub touch: Touch,
}

/// How a body touches others.
#[derive(Clone, Copy, Debug, Default)]
pub struct Touch {
    /// Smallest gap of all pairs that interact [m].
    pub gap: Option<f64>,
    /// Sum of the forces of contact on it [N]; in the plane per depth [N/m].
    pub force: Vec3,
}

/// One time step, here and there.
#[derive(Clone, Copy, Debug)]
pub struct Compared {
    /// From 1.
    pub step: usize,
    /// Largest distance between probes over the largest displacement.
    pub difference: f64,
    /// Elastic energy, ours and theirs [J], per depth [J/m].
    pub elastic: [f64; 2],
    /// Ours and theirs.
    pub touch: [Touch; 2],
}

/// A file of `../shared/reference`, where it is at hand.
pub fn reference(name: &str) -> Option<Reference> {
    let path = shared(&format!("reference/{name}.json"))?;
    let text = std::fs::read_to_string(path).expect("readable");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let ids = json["nodes"]["mesh_vertex_id_0based"].as_array().expect("ids");
    let id = |v: &Value| v.as_u64().and_then(|v| v.try_into().ok()).expect("an id");
    let steps = json["steps"].as_array().expect("steps").iter();
    let steps = steps.filter_map(|step| probed(&json, step)).collect();
    Some(Reference { vertices: ids.iter().map(id).collect(), steps })
}

/// None of the state at rest.
fn probed(json: &Value, step: &Value) -> Option<Probed> {
    let vector = |u: &Value| Vec3::from_fn(|k, _| u[k].as_f64().unwrap_or(0.0));
    let number = &step["step"];
    // a row is an object, or a list that begins with the step and ends with the gap
    let row = |list: &str, last: &str, which: &dyn Fn(&Value) -> bool| -> Option<Value> {
        let row = json[list].as_array()?.iter().find(|row| which(row))?;
        Some(row.get(last).or_else(|| row.as_array()?.last()).cloned().unwrap_or_default())
    };
    let gap = row("newton", "min_dist", &|row| row["step"] == *number)
        .or_else(|| row("newton_iters", "min_dist", &|row| row[0] == *number));
    let force = row("contact", "contact_on_body_N", &|row| row["step"] == *number);
    let energies = json["energies_J_6digits"]["rows"].as_array()?;
    Some(Probed {
        elastic: energies.iter().find(|row| row[0].as_f64() == number.as_f64())?[1].as_f64()?,
        u: step["u_m"].as_array()?.iter().map(vector).collect(),
        step: number.as_u64().and_then(|n| n.try_into().ok())?,
        largest: step["max_abs_u_m"].as_f64()?,
        touch: Touch {
            gap: gap.and_then(|gap| gap.as_f64()),
            force: force.map_or_else(Vec3::zeros, |force| vector(&force)),
        },
    })
}

/// A published scene, changed by `edit`, as imported, and the folder in which
/// it lies.
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
    let imported = polyfem::read(&dir.path("scene.json"), options);
    let imported = imported.unwrap_or_else(|e| panic!("{e:#}"));
    imported.write(&dir.path("")).expect("the folder is writable");
    let scene = Scene::read(&dir.path("sim.toml")).unwrap_or_else(|e| panic!("{e:#}"));
    Some((dir, scene))
}

/// Goes through the first `count` time steps and compares those that the reference
/// has. Forces of slabs are per depth.
pub fn compare(scene: Scene, reference: &Reference, count: usize) -> Vec<Compared> {
    let mut motion = Motion::of(scene);
    let mut all = Vec::new();
    for step in 1..=count {
        motion.go(1);
        let Some(theirs) = reference.steps.iter().find(|s| s.step == step) else { continue };
        let distance = |(&v, u): (&usize, &Vec3)| (at(motion.u(), v) - u).norm();
        let worst = reference.vertices.iter().zip(&theirs.u).map(distance).fold(0.0, f64::max);
        let difference = worst / theirs.largest;
        let (elastic, ours) = state(&mut motion);
        let (elastic, touch) = ([elastic, theirs.elastic], [ours, theirs.touch]);
        eprintln!(
            "step {step}: off by {difference:.2e} of the largest displacement, elastic energy \
             {:.6e} and {:.5e}",
            elastic[0], elastic[1]
        );
        if let [Some(ours), Some(theirs)] = touch.map(|t| t.gap) {
            let [f, g] = touch.map(|t| t.force.norm());
            eprintln!("  force {f:.6} and {g:.6}, gap {ours:.6e} and {theirs:.6e} m");
        }
        all.push(Compared { step, difference, elastic, touch });
    }
    all
}

/// Elastic energy now, and how the first body touches others.
fn state(motion: &mut Motion) -> (f64, Touch) {
    let config = &motion.scene.config;
    let activation = config.contact().and_then(|contact| contact.activation).unwrap_or(0.0);
    let slab = config.fixed.iter().any(|f| f.components == "z");
    let (low, high) = mesh::measure::bounds(&motion.scene.body.mesh.vertices);
    let depth = if slab { high.z - low.z } else { 1.0 };
    let name = motion.scene.parts[0].config.name.clone();
    let report = motion.report();
    let elastic = report["energies"]["elastic"].as_f64().expect("a number") / depth;
    let collisions = &report["collisions"];
    let forces = collisions["contact"].as_array().into_iter().flatten();
    let force = |f: &Value| Vec3::from_fn(|k, _| f["force"][k].as_f64().expect("a number"));
    let touch = Touch {
        gap: collisions["smallest_gap"].as_f64().map(|gap| gap * activation),
        force: forces.filter(|f| f["bodies"][0] == *name).map(force).sum::<Vec3>() / depth,
    };
    (elastic, touch)
}
