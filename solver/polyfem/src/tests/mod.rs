mod slips;

use std::path::Path;

use mechanics::contact::potential::Partners;
use mechanics::forward::Method;
use mechanics::testing::cube;
use mesh::{Tags, Vec3};
use serde_json::{Value, json};

use super::*;

/// A cube of side 2 m with id 7: sides by its low x, high x, and the rest.
fn scene() -> Value {
    json!({
        "geometry": [{
            "mesh": "block.msh",
            "volume_selection": 7,
            "transformation": { "scale": 2.0, "translation": [1.0, 0.0, -1.0] },
            "surface_selection": [
                { "id": 1, "axis": "-x", "position": 1.001 },
                { "id": 2, "axis": "x", "position": 2.999, "relative": false },
                { "id": 3, "box": [[1, -1, -2], [3, 3, 0]] },
            ],
        }],
        "space": { "discr_order": 2, "advanced": { "quadrature_order": 5 } },
        "time": { "t0": 0, "tend": 0.3, "dt": 0.1 },
        "contact": { "enabled": true, "dhat": 1e-4, "use_convergent_formulation": true },
        "solver": { "contact": { "barrier_stiffness": 1e5 } },
        "boundary_conditions": {
            "rhs": [0, "2*t", 9.8],
            "dirichlet_boundary": [{ "id": 1, "value": [0, 0, 0] }],
            "pressure_boundary": [{ "id": 3, "value": "-60 * half_smoothstep(t)" }],
        },
        "materials": [
            { "id": 6, "type": "NeoHookean", "E": 1e3, "nu": 0.2, "rho": 900 },
            { "id": 7, "type": "NeoHookean", "E": 1e5, "nu": 0.35, "rho": 1000 },
        ],
    })
}

/// Writes the files of a scene and a JSON file, and reads it.
fn read(json: &Value, options: &Options) -> Result<(Imported, SimConfig)> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    mesh::io::write_tets(&at("block.msh"), &cube(2, 0.0), &Tags::default()).expect("writable");
    std::fs::write(at("plane.obj"), "v 0 0\nv 1 0\nv 1 1\nv 0 1\nf 1 2 3\nf 3 4 1\n")
        .expect("writable");
    std::fs::write(at("wall.obj"), "v 0 0 9\nv 1 0 9\nv 1 1 9\nf 1 2 3\n").expect("writable");
    let facets = mesh::topology::boundary(&cube(2, 0.0)).facets;
    let line = |(id, [a, b, c]): (i64, [usize; 3])| format!("{id} {c} {a} {b}\n");
    // the first three facets, the first of them twice
    let all = [(5, facets[0]), (6, facets[1]), (9, facets[0]), (5, facets[2])];
    std::fs::write(at("listed.txt"), all.map(line).concat()).expect("writable");
    std::fs::write(at("strangers.txt"), "1 0 1 2\n1 0 13 26\n").expect("writable");
    std::fs::write(at("scene.json"), json.to_string()).expect("writable");
    let imported = super::read(&at("scene.json"), options)?;
    let values = SimConfig::settings_of(imported.scene.values.clone()).expect("checked");
    let config = SimConfig::of(&values).expect("checked");
    Ok((imported, config))
}

/// The scene with the value at a pointer replaced, or added to a list or object.
fn with(pointer: &str, value: Value) -> Value {
    let mut scene = scene();
    set(&mut scene, pointer, value);
    scene
}

fn set(scene: &mut Value, pointer: &str, value: Value) {
    let (parent, name) = pointer.rsplit_once('/').expect("a pointer");
    match scene.pointer_mut(parent).expect(parent) {
        Value::Object(members) => drop(members.insert(name.to_owned(), value)),
        Value::Array(items) if name == "-" => items.push(value),
        Value::Array(items) => items[name.parse::<usize>().expect("a number")] = value,
        other => panic!("{pointer}: {other}"),
    }
}

fn sound(json: &Value) -> (Imported, SimConfig) {
    read(json, &Options::default()).expect("sound")
}

/// The number of facets of each tag of the first body.
fn counts(imported: &Imported) -> Vec<(&str, usize)> {
    let tags = &imported.scene.geometry.solids[0].tags;
    tags.names.iter().zip(1..).map(|(name, id)| (&name[..], tags.facets_of(id).len())).collect()
}

#[test]
fn bodies_are_placed_and_the_first_selection_counts() {
    let (imported, config) = sound(&scene());
    let body = &imported.scene.geometry.solids[0];
    assert_eq!(
        mesh::measure::bounds(&body.mesh.vertices),
        (Vec3::new(1.0, 0.0, -1.0), Vec3::new(3.0, 2.0, 1.0))
    );
    // the box takes half of each side but of those that were taken before it
    assert_eq!(counts(&imported), [("s1", 8), ("s2", 8), ("s3", 16), ("unselected", 16)]);
    assert_eq!((config.degree, config.quadrature, config.fixed[0].on.as_str()), (2, 5, "s1"));
    assert!(config.body.is_empty() && config.mesh.as_deref() == Some(Path::new("block.msh")));
}

#[test]
fn selections_of_every_kind_are_understood() {
    for (selection, expected) in [
        (json!(30), &[("s30", 48)][..]),
        (json!("listed.txt"), &[("s5", 2), ("s6", 1), ("unselected", 45)]),
        (json!(["listed.txt", 4]), &[("s4", 45), ("s5", 2), ("s6", 1)]),
        (
            json!([{ "id": 8, "axis": -2, "position": 0.001, "relative": true }]),
            &[("s8", 8), ("unselected", 40)],
        ),
        (
            json!([{ "id": 8, "box": [[0, 0, 0.9], [1, 1, 1]], "relative": true }]),
            &[("s8", 8), ("unselected", 40)],
        ),
        (
            json!([{ "id": 8, "center": [1, 0, -1], "radius": 1.0 }]),
            &[("s8", 6), ("unselected", 42)],
        ),
    ] {
        let mut scene = with("/geometry/0/surface_selection", selection.clone());
        set(&mut scene, "/boundary_conditions", json!({}));
        let (imported, _) = sound(&scene);
        assert_eq!(counts(&imported), expected, "{selection}");
        assert_eq!(imported.left().len(), 1, "{:?}", imported.left());
    }
}

#[test]
fn every_key_without_a_part_is_named() {
    let mut scene = scene();
    let unused = ["no body is made of it: /materials/0"];
    assert_eq!(sound(&scene).0.warnings(), unused);
    let strangers = [
        "/wobble",
        "/contact/fancy",
        "/time/extra",
        "/space/advanced/odd",
        "/materials/1/phi",
        "/geometry/0/colour",
        "/geometry/0/surface_selection/0/point",
        "/geometry/0/transformation/skew",
        "/boundary_conditions/what",
        "/boundary_conditions/dirichlet_boundary/0/interpolation",
        "/solver/contact/new",
        "/solver/tricks",
    ];
    for pointer in strangers {
        set(&mut scene, pointer, json!({ "a": [1, { "b": 2 }] }));
    }
    set(&mut scene, "/output", json!({ "log": { "level": "debug" } }));
    // of another body
    let (imported, _) = sound(&scene);
    let left = imported.left();
    let mut found = left["unknown key"].clone();
    found.sort();
    let mut expected = strangers.map(str::to_owned);
    expected.sort();
    assert_eq!(found, expected);
    assert_eq!(left["solver simulate writes its own files"], ["/output/log/level"]);
    assert!(imported.warnings().iter().any(|w| w.contains("unknown key: /boundary_conditions/")));

    let folder = tempfile::tempdir().expect("a temporary folder");
    imported.write(folder.path()).expect("writable");
    let report = mesh::io::read_text(&folder.path().join("import.report.json")).expect("written");
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["left"]["/wobble"], "unknown key");
}

#[test]
fn loads_keep_their_sense_and_reach_every_body_with_their_id() {
    let mut scene = scene();
    let mut second = scene["geometry"][0].clone();
    second["transformation"] = json!({ "scale": [1, 2, 3] });
    second["volume_selection"] = json!(6);
    second["surface_selection"] = json!([{ "id": 1, "axis": "-z", "position": 0.001 }]);
    set(&mut scene, "/geometry/-", second);
    let moved =
        json!({ "id": [2, 77], "value": ["0.1*t", 5, 0.2], "dimension": [true, false, true] });
    set(&mut scene, "/boundary_conditions/dirichlet_boundary/-", moved);
    set(
        &mut scene,
        "/boundary_conditions/dirichlet_boundary/-",
        json!({ "id": 78, "value": [0, 0, 0] }),
    );
    let traction = json!([{ "id": 3, "value": [0, "3*x", 1] }]);
    set(&mut scene, "/boundary_conditions/neumann_boundary", traction);
    let velocity = json!({ "velocity": [{ "id": 6, "value": [1, 0, -2] }] });
    set(&mut scene, "/initial_conditions", velocity);
    let (imported, config) = sound(&scene);

    assert_eq!([0, 1].map(|i| config.body[i].name.as_str()), ["block", "block_2"]);
    assert_eq!(config.body[1].velocity, [1.0, 0.0, -2.0]);
    let density = |i: usize| config.body[i].material.specification().expect("known").density;
    assert_eq!([density(0), density(1)], [Some(1000.0), Some(900.0)]);
    let on: Vec<&str> = config.fixed.iter().map(|f| f.on.as_str()).collect();
    assert_eq!(on, ["block.s1", "block_2.s1", "block.s2"]);
    assert_eq!(config.fixed[2].components, "xz");
    let x = Vec3::new(4.0, 0.0, 0.0);
    assert_eq!(config.field(&config.fixed[2].displacement).at(x, 0.5), Vec3::new(0.05, 0.0, 0.2));
    assert_eq!(config.field(&config.gravity).at(x, 0.5), Vec3::new(0.0, -1.0, -9.8));
    assert_eq!(config.field(&config.traction[0].traction).at(x, 0.5), Vec3::new(0.0, 12.0, 1.0));
    assert_eq!(config.chamber[0].name, "block.s3");
    assert_eq!(config.schedule(&config.chamber[0].gas.value).at(1.0), 60.0);
    let nobody = "no body has a facet with this id".to_owned();
    assert_eq!(imported.left()[&nobody], ["/boundary_conditions/dirichlet_boundary/2"]);
}

#[test]
fn time_is_counted_from_zero() {
    let (_, config) = sound(&with("/time", json!({ "t0": 2, "tend": 3.1, "dt": 0.02 })));
    assert_eq!((config.times().len(), config.times()[54]), (55, 1.1));
    // what was at t = 2 s is now at 0
    assert!((config.field(&config.gravity).at(Vec3::zeros(), 0.5).y + 5.0).abs() < 1e-12);
    for (time, expected) in [
        (json!({ "dt": 0.1, "time_steps": 4 }), Method::ImplicitEuler),
        (json!({ "tend": 0.4, "time_steps": 4, "integrator": "BDF2" }), Method::Bdf2),
        (
            json!({ "tend": 0.4, "dt": 0.1, "integrator": { "type": "BDF", "steps": 3 } }),
            Method::Bdf3,
        ),
        (json!({ "tend": 0.4, "dt": 0.1, "quasistatic": true }), Method::Quasistatic),
    ] {
        let (_, config) = sound(&with("/time", time));
        assert_eq!((config.method(), config.times().len()), (expected, 4));
        assert!((config.times()[3] - 0.4).abs() < 1e-15);
    }
}

#[test]
fn the_form_of_contact_is_that_of_the_file() {
    let form = |json: &Value, form: Option<ContactForm>| {
        let (imported, config) = read(json, &Options { form, thickness: None }).expect("sound");
        let contact = config.contact().expect("on");
        assert_eq!(contact.pairs.partners(), Partners::All, "that of PolyFEM");
        (contact.form, imported.scene.notes.len())
    };
    let plain = with("/contact/use_convergent_formulation", Value::Null);
    assert_eq!(form(&scene(), None), (ContactForm::Convergent, 0));
    assert_eq!(form(&plain, None), (ContactForm::Plain, 1));
    assert_eq!(form(&plain, Some(ContactForm::Convergent)), (ContactForm::Convergent, 0));
    let options = Options { form: Some(ContactForm::Plain), thickness: Some(1e-3) };
    let (imported, config) =
        read(&with("/contact/enabled", json!(false)), &options).expect("sound");
    assert!(config.contact.is_none());
    let notes = &imported.scene.notes;
    assert!(notes[0].contains("contact is off") && notes[1].contains("not plane"), "{notes:?}");
    assert_eq!(imported.left()["contact is off"], ["/contact", "/solver/contact"]);
}

#[test]
fn plane_bodies_become_slabs_of_the_same_law() {
    let mut scene = scene();
    scene["geometry"] = json!([{
        "mesh": "plane.obj",
        "volume_selection": 7,
        "transformation": { "scale": [0.5, 1.0], "translation": [0.0, 3.0] },
        "surface_selection": [{ "id": 1, "box": [[-1, 3.9], [2, 5]] }, { "id": 3, "axis": "x", "position": 0.4 }],
    }]);
    set(&mut scene, "/boundary_conditions/rhs", json!([0, 1]));
    set(&mut scene, "/boundary_conditions/dirichlet_boundary/0/value", json!([0, "0.1*z"]));
    let options = Options { form: None, thickness: Some(0.125) };
    let (imported, config) = read(&scene, &options).expect("sound");
    let body = &imported.scene.geometry.solids[0];
    assert_eq!(counts(&imported), [("s1", 2), ("s3", 2), ("unselected", 4), ("s_planar", 4)]);
    let (low, high) = mesh::measure::bounds(&body.mesh.vertices);
    assert_eq!((low, high), (Vec3::new(0.0, 3.0, 0.0), Vec3::new(0.5, 4.0, 0.125)));
    assert!((mesh::measure::volume(&body.mesh) - 0.5 * 0.125).abs() < 1e-15);
    let fixed: Vec<[&str; 2]> = config.fixed.iter().map(|f| [&*f.on, &*f.components]).collect();
    assert_eq!(fixed, [["plane.s1", "xy"], ["plane", "z"]]);
    assert_eq!(config.field(&config.fixed[0].displacement).at(high, 1.0), Vec3::zeros());
    assert_eq!(config.field(&config.gravity).at(low, 1.0), Vec3::new(0.0, -1.0, 0.0));

    // λ and μ of the plane
    let (e, nu) = (1e5, 0.35);
    let (lambda, mu) = (e * nu / (1.0 - nu * nu), e / (2.0 * (1.0 + nu)));
    let moduli = config.body[0].material.specification().expect("known").moduli();
    assert!((moduli.shear / mu - 1.0).abs() < 1e-14);
    assert!((moduli.bulk / (lambda + 2.0 / 3.0 * mu) - 1.0).abs() < 1e-14);

    // a tenth of the mean edge: 0.5, 0.5, 1, 1, and the diagonal
    let (imported, _) = sound(&scene);
    let mean = 0.1 * (3.0 + 1.25_f64.sqrt()) / 5.0;
    assert!((imported.scene.geometry.thickness.expect("plane") - mean).abs() < 1e-15);
}

#[test]
fn obstacles_are_surfaces_that_move() {
    let mut scene = scene();
    let wall = json!({ "mesh": "wall.obj", "is_obstacle": true, "surface_selection": 40, "transformation": { "scale": 0.5 } });
    set(&mut scene, "/geometry/-", wall);
    let moves = json!([{ "id": 40, "value": [0, "-t", 0] }]);
    set(&mut scene, "/boundary_conditions/obstacle_displacements", moves);
    let (imported, config) = sound(&scene);
    assert_eq!(config.field(&config.obstacle[0].displacement).at(Vec3::zeros(), 0.5).y, -0.5);
    let folder = tempfile::tempdir().expect("a temporary folder");
    imported.write(folder.path()).expect("writable");
    let wall = mesh::io::read_surface(&folder.path().join(&config.obstacle[0].surface));
    assert_eq!(wall.expect("written").vertices[2], Vec3::new(0.5, 0.5, 4.5));
    assert_eq!(imported.left().len(), 1, "{:?}", imported.left());
}
