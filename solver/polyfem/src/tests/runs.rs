use ::scene::config::{ContactForm, DesignConfig, HandlesConfig, ObjectiveConfig};
use serde_json::{Value, json};

use super::sound;

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
            { "type": "transient_integral", "integral_type": "steps", "steps": [9],
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
            { "type": "transient_integral", "weight": 5e5, "integral_type": "final",
              "static_objective": { "type": "displacement-target", "surface_selection": [1, 2],
                "target_displacement": [0.03, 0, 0], "active_dimension": [true, false, false] } },
            { "type": "transient_integral", "weight": -1e4, "integral_type": "steps",
              "steps": [2, 3], "static_objective": {
                "type": "log_contact_force_norm", "surface_selection": [1, 2], "dhat": 1e-3 } },
            { "type": "transient_integral", "integral_type": "simpson", "print_energy": "far",
              "static_objective": { "type": "quadratic_contact_force_norm",
                "surface_selection": [2, 3], "dhat": 0.002 } },
        ],
    })
}

#[test]
fn an_optimisation_becomes_a_design_problem() {
    let (imported, _) = sound(&run());
    let design = imported.design.as_ref().expect("a shape may change");
    let config: DesignConfig = toml::from_str(&design.text).expect("sound");
    let shape = config.shape.expect("a shape");
    assert_eq!(
        (shape.on.all(), shape.level[0].handles.clone()),
        (&["s3".to_owned()][..], Some(HandlesConfig::Each(5)))
    );
    assert_eq!(shape.level[0].iterations, 40);
    let short = |o: &ObjectiveConfig| {
        let written = toml::Table::try_from(o).expect("sound");
        let rest = written.iter().filter(|(key, _)| !["name", "weight"].contains(&key.as_str()));
        let rest: Vec<String> = rest.map(|(key, value)| format!("{key} {value}")).collect();
        let weight = written["weight"].as_float().expect("a number");
        format!("{}: {weight} {}", o.name(), rest.join(", ")).replace('"', "")
    };
    let terms: Vec<String> = config.objective.iter().map(short).collect();
    assert_eq!(
        terms,
        [
            "match: 100000000 distance unsigned, kind target, measure rest, on s2, over final, \
             spacing 0.002, target targets/wall.obj",
            "match 2: 200000000 distance unsigned, kind target, measure rest, on s1, \
             over { steps = [2] }, spacing 0.001, target targets/wall.obj",
            "layer_thickness_log: 3000000 activation 0.002, density log, kind wall-thickness, \
             measure rest, minimum 0.001, on [s1, s2, unselected], over final",
            "layer_thickness: 3000000 activation 0.002, density quadratic, kind wall-thickness, \
             measure rest, on [s1, s2], over final",
            "clear: 1 activation 0.00005, kind clearance, over final",
            "boundary_smoothing: 0.7 form scale-invariant, kind smoothness, on s3, over final",
            "displacement-target: 500000 components x, displacement [0.03, 0.0, 0.0], \
             kind displacement, measure rest, on [s1, s2], over final",
            "log_contact_force_norm: -10000 activation 0.001, density log, kind contact-proxy, \
             on [s1, s2], over { steps = [2, 3] }",
            "far: 1 activation 0.002, density quadratic, kind contact-proxy, on [s2, s3], \
             over simpson",
        ]
    );
    let left = imported.left();
    let why = |words: &str| {
        left.iter().find(|(why, _)| why.contains(words)).map(|l| l.1.join(" ")).unwrap_or_default()
    };
    assert_eq!(why("the scene has no step 9"), "/functionals/2");
    assert_eq!(why("scale-invariant and quadratic"), "/functionals/7");
    assert_eq!(why("not negative"), "/functionals/8");
    assert_eq!(why("no such objective"), "/functionals/9");
    assert_eq!(why("a table [[chamber]]"), "/variable_to_simulation/0");
    assert!(left.keys().all(|why| !why.contains("unknown key")), "{left:?}");
    let notes = imported.scene.notes.join("\n");
    for words in [
        "\"elsewhere/state.json\" is not there; taken is",
        "Simpson's rule",
        "17 vertices are said to move, 15 are",
    ] {
        assert!(notes.contains(words), "{words}: {notes}");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    imported.write(folder.path()).expect("writable");
    for name in ["sim.toml", "design.toml", "block.msh", "targets/wall.obj", "import.report.json"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
    let scene = ::scene::Scene::read(&folder.path().join("sim.toml")).expect("ours");
    assert_eq!(scene.body.facets("s3").expect("there").len(), 16);
}

#[test]
fn the_form_of_an_optimisation_is_convergent() {
    let mut run = run();
    run["states"][0]["path"] = json!("plain.json");
    let (imported, config) = sound(&run);
    assert_eq!(config.contact().expect("on").form, ContactForm::Convergent);
    let notes = imported.scene.notes.join("\n");
    assert!(notes.contains("switches to it in an optimisation"), "{notes}");
}

#[test]
fn several_tags_may_move() {
    let mut run = run();
    let mut second = run["variable_to_simulation"][1].clone();
    second["surface_selection"] = json!([2]);
    second["composition"][1]["num_control_vertices"] = json!(9);
    run["variable_to_simulation"].as_array_mut().expect("a list").push(second);
    let (imported, _) = sound(&run);
    let design: toml::Table =
        toml::from_str(&imported.design.as_ref().expect("shapes").text).expect("TOML");
    let on: Vec<&str> = design["shape"]["on"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|v| v.as_str())
        .collect();
    assert_eq!(on, ["s3", "s2"]);
    let handles = &design["shape"]["level"][0]["handles"];
    assert_eq!((handles["s3"].as_integer(), handles["s2"].as_integer()), (Some(5), Some(9)));
}

#[test]
fn pressures_change_by_bounded_slopes() {
    let mut run = run();
    let composition = json!([
        { "type": "slice", "parameter_index": 0 },
        { "type": "scale", "value": 1000.0 },
        { "type": "scalar-velocity-parametrization", "start_val": 0.0, "dt": 0.1 },
    ]);
    run["variable_to_simulation"] = json!([{ "type": "pressure", "surface_selection": [3],
        "composite_map_type": "time_step_indexing", "composition": composition }]);
    run["solver"]["nonlinear"]["box_constraints"] = json!({ "bounds": [-5, 4], "max_change": 1 });
    let (imported, _) = sound(&run);
    let design = imported.design.as_ref().expect("a pressure may change");
    let config: DesignConfig = toml::from_str(&design.text).expect("sound");
    assert!(config.shape.is_none());
    assert_eq!(config.optimizer.iterations, Some(40));
    let pressure = &config.chamber[0];
    assert_eq!((pressure.on.as_str(), pressure.slope), ("s3", [-4000.0, 5000.0]));
    assert_eq!((pressure.change, config.objective.len()), (Some(1000.0), 9));
    let left = imported.left();
    let of_variables: Vec<&String> =
        left.values().flatten().filter(|key| key.starts_with("/variable")).collect();
    assert_eq!(of_variables, ["/variable_to_simulation/0/composition/0/parameter_index"]);
}
