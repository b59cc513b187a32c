use serde_json::{Value, json};

use super::sound;
use crate::config::{ContactForm, DesignConfig, ObjectiveConfig};

/// An optimisation of the scene.
pub fn run() -> Value {
    json!({
        "states": [{ "path": "elsewhere/state.json" }],
        "variable_to_simulation": [
            { "type": "pressure", "surface_selection": [3] },
            { "type": "shape", "composite_map_type": "boundary", "surface_selection": [3], "state": 0,
              "composition": [
                { "type": "slice", "parameter_index": 0 },
                { "type": "bounded-biharmonic-weights", "num_control_vertices": 5,
                  "num_vertices": 17, "allow_rotations": true } ] },
        ],
        "parameters": [{ "number": 30 }],
        "solver": { "nonlinear": { "max_iterations": 40, "solver": "L-BFGS" } },
        "functionals": [
            { "type": "mesh-target", "weight": 1e8, "print_energy": "match", "state": 0,
              "surface_selection": [2], "mesh_path": "wall.obj", "delta": 0.002 },
            { "type": "transient_integral", "weight": 2e8, "print_energy": "match", "state": 0,
              "integral_type": "steps", "steps": [2], "static_objective": {
                "type": "mesh-target", "state": 0, "surface_selection": [1],
                "mesh_path": "wall.obj", "delta": 0.001 } },
            { "type": "transient_integral", "integral_type": "steps", "steps": [1],
              "static_objective": { "type": "mesh-target" } },
            { "type": "layer_thickness_log", "weight": 3e6, "boundary_ids": [1, 2, 2147483647],
              "dhat": 0.002, "dmin": 0.001 },
            { "type": "layer_thickness", "weight": 3e6, "boundary_ids": [1, 2], "dhat": 0.002 },
            { "type": "collision_barrier", "print_energy": "clear", "weight": 1, "dhat": 5e-5 },
            { "type": "boundary_smoothing", "weight": 0.7, "surface_selection": [3], "power": 2,
              "scale_invariant": true },
            { "type": "boundary_smoothing", "weight": 0.7, "surface_selection": [3], "power": 3 },
            { "type": "contact_force", "weight": -1e4 },
            { "type": "stress" },
        ],
    })
}

#[test]
fn an_optimisation_becomes_a_design_problem() {
    let (imported, _) = sound(&run());
    let design = imported.design.as_ref().expect("a shape may change");
    let config: DesignConfig = toml::from_str(&design.text).expect("sound");
    let shape = config.shape.expect("a shape");
    assert_eq!((shape.on.all(), shape.level[0].handles), (&["s3".to_owned()][..], Some(5)));
    assert_eq!(shape.level[0].iterations, 40);
    let short = |o: &ObjectiveConfig| match o {
        ObjectiveConfig::Target { name, weight, on, target, spacing } => {
            format!("{name}: {weight} {on} {} {spacing}", target.display())
        }
        ObjectiveConfig::WallThickness { name, weight, on, against, minimum, activation } => {
            format!("{name}: {weight} {on} {against:?} {minimum} {activation}")
        }
        ObjectiveConfig::Smoothness { name, weight, on } => format!("{name}: {weight} {on}"),
        ObjectiveConfig::Clearance { name, weight, activation } => {
            format!("{name}: {weight} {activation}")
        }
    };
    let terms: Vec<String> = config.objective.iter().map(short).collect();
    assert_eq!(
        terms,
        [
            "match: 100000000 s2 targets/wall.obj 0.002",
            "match 2: 200000000 s1 targets/wall.obj 0.001",
            "layer_thickness_log: 3000000 s1 [\"s2\", \"unselected\"] 0.001 0.002",
            "layer_thickness_log 2: 3000000 s2 [\"unselected\"] 0.001 0.002",
            "clear: 1 0.00005",
            "boundary_smoothing: 0.7 s3",
        ]
    );
    let left = imported.left();
    let why = |words: &str| {
        left.iter().find(|(why, _)| why.contains(words)).map(|l| l.1.join(" ")).unwrap_or_default()
    };
    assert_eq!(why("at the end of the scene only"), "/functionals/2");
    assert_eq!(why("the form with a smallest thickness"), "/functionals/4");
    assert_eq!(why("scale-invariant and quadratic"), "/functionals/7");
    assert_eq!(why("not negative"), "/functionals/8");
    assert_eq!(why("no such objective"), "/functionals/9");
    assert_eq!(why("only shapes are design variables"), "/variable_to_simulation/0");
    assert!(left.keys().all(|why| !why.contains("unknown key")), "{left:?}");
    let notes = imported.scene.notes.join("\n");
    for words in [
        "\"elsewhere/state.json\" is not there; taken is",
        "step 3, in place of steps [2]",
        "17 vertices are said to move, 15 are",
    ] {
        assert!(notes.contains(words), "{words}: {notes}");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    imported.write(folder.path()).expect("writable");
    for name in ["sim.toml", "design.toml", "block.msh", "targets/wall.obj", "import.report.json"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
    let scene = crate::scene::Scene::read(&folder.path().join("sim.toml")).expect("ours");
    assert_eq!(scene.body.facets("s3").expect("there").len(), 16);
}

#[test]
fn the_form_of_an_optimisation_is_convergent() {
    let mut run = run();
    run["states"][0]["path"] = json!("plain.json");
    let (imported, config) = sound(&run);
    assert_eq!(config.contact.expect("on").form, ContactForm::Convergent);
    let notes = imported.scene.notes.join("\n");
    assert!(notes.contains("switches to it in an optimisation"), "{notes}");
}
