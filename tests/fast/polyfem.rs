//! Scenes of PolyFEM: the first steps of published ones against those of PolyFEM, what `solver import` says and what it
//! refuses.

use mechanics::element::at;
use mesh::Vec3;
use polyfem::Options;
use scene::Scene;
use serde_json::Value;
use solver::plot::{Axes, Series, Style, draw};
use tests::motion::Motion;
use tests::published::{FOLDER, gripper};
use tests::shared;
use tests::workdir::{Workdir, repository};

/// What PolyFEM found.
struct Reference {
    /// Vertices of the first body that are compared.
    vertices: Vec<usize>,
    /// Its time steps.
    steps: Vec<Probed>,
}

/// A time step of PolyFEM.
struct Probed {
    /// From 1.
    step: usize,
    /// Displacement of the vertices; no component along z in the plane [m].
    u: Vec<Vec3>,
    /// Largest displacement of all nodes [m].
    largest: f64,
    /// Elastic energy of all bodies, to six digits [J]; in the plane per depth [J/m]. Not known of static runs.
    elastic: Option<f64>,
    /// How the first body touches others.
    touch: Touch,
}

/// How a body touches others.
#[derive(Clone, Copy, Default)]
struct Touch {
    /// Smallest gap of all pairs that interact [m].
    gap: Option<f64>,
    /// Sum of the forces of contact on it [N]; in the plane per depth [N/m].
    force: Vec3,
}

/// One time step, here and there.
#[derive(Clone, Copy)]
struct Compared {
    /// From 1.
    step: usize,
    /// Largest distance between probes over the largest displacement.
    difference: f64,
    /// Elastic energy, ours over theirs; 1 where theirs is not known.
    elastic: f64,
    /// Ours and theirs.
    touch: [Touch; 2],
}

/// A file of `../shared/reference`, where it is at hand.
fn reference(name: &str) -> Option<Reference> {
    let path = shared(&format!("reference/{name}.json"))?;
    let text = std::fs::read_to_string(path).unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    let ids = json["nodes"]["mesh_vertex_id_0based"].as_array().unwrap();
    let id = |v: &Value| v.as_u64().and_then(|v| v.try_into().ok()).unwrap();
    let steps = json["steps"].as_array().unwrap().iter();
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
    let mut energies = json["energies_J_6digits"]["rows"].as_array().into_iter().flatten();
    Some(Probed {
        elastic: energies
            .find(|row| row[0].as_f64() == number.as_f64())
            .and_then(|row| row[1].as_f64()),
        u: step["u_m"].as_array()?.iter().map(vector).collect(),
        step: number.as_u64().and_then(|n| n.try_into().ok())?,
        largest: step["max_abs_u_m"].as_f64()?,
        touch: Touch {
            gap: gap.and_then(|gap| gap.as_f64()),
            force: force.map_or_else(Vec3::zeros, |force| vector(&force)),
        },
    })
}

/// A published scene as imported, and the folder in which it lies.
fn scene(file: &str, options: &Options) -> Option<(Workdir, Scene)> {
    let path = shared(&format!("{FOLDER}/{file}"))?;
    let dir = Workdir::new();
    let imported = polyfem::read(&path, options);
    let imported = imported.unwrap();
    imported.write(&dir.path("")).unwrap();
    let scene = Scene::read(&dir.path("sim.toml")).unwrap();
    Some((dir, scene))
}

/// Goes through the first `count` time steps and compares those that the reference
/// has. Forces of slabs are per depth.
fn compare(scene: Scene, reference: &Reference, count: usize) -> Vec<Compared> {
    let mut motion = Motion::of(scene);
    let mut all = Vec::new();
    for step in 1..=count {
        motion.go(1);
        let Some(theirs) = reference.steps.iter().find(|s| s.step == step) else { continue };
        let distance = |(&v, u): (&usize, &Vec3)| (at(motion.u(), v) - u).norm();
        let worst = reference.vertices.iter().zip(&theirs.u).map(distance).fold(0.0, f64::max);
        let difference = worst / theirs.largest;
        let (elastic, ours) = state(&mut motion);
        let touch = [ours, theirs.touch];
        eprintln!(
            "step {step}: off by {difference:.2e} of the largest displacement, elastic energy {elastic:.6e}"
        );
        let elastic = elastic / theirs.elastic.unwrap_or(elastic);
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
    let elastic = report["energies"]["elastic"].as_f64().unwrap() / depth;
    let collisions = &report["collisions"];
    let forces = collisions["contact"].as_array().into_iter().flatten();
    let force = |f: &Value| Vec3::from_fn(|k, _| f["force"][k].as_f64().unwrap());
    let touch = Touch {
        gap: collisions["smallest_gap"].as_f64().map(|gap| gap * activation),
        force: forces.filter(|f| f["bodies"][0] == *name).map(force).sum::<Vec3>() / depth,
    };
    (elastic, touch)
}

/// Asserts how far probes and elastic energies are off before and after surfaces meet, as a fraction
/// of the largest displacement.
fn agree(steps: &[Compared], contact: usize, before: f64, after: f64) {
    assert!(!steps.is_empty());
    for &Compared { step, difference, elastic, .. } in steps {
        let limit = if step < contact { before } else { after };
        assert!(difference < limit, "step {step}: {difference:.2e}, not below {limit:.0e}");
        // six digits are known, and it grows with the square of the displacement
        let limit = 1e-5 + 10.0 * limit;
        assert!((elastic - 1.0).abs() < limit, "step {step}: {elastic} of the elastic energy");
    }
}

/// The gripper alone, at 5 kPa without contact and without inertia.
fn gripper_at_rest(degree: usize) {
    let Some(reference) = reference(&format!("gripper_static5k_p{degree}")) else { return };
    let Some(body) = gripper() else { return };
    let dir = Workdir::with(&body);
    dir.write(
        "sim.toml",
        &format!(
            "mesh = \"body.msh\"\ndegree = {degree}\n[solver]\nfirst_load_step = 1.0\n[material]\n\
             kind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\nd1 = 1e6\n[[fixed]]\non = \"fixed\"\n\
             [[chamber]]\non = \"cavity\"\npressure = 5e3\n"
        ),
    );
    let scene = Scene::read(&dir.path("sim.toml")).unwrap();
    // the reference stopped at a relative gradient of 1e-6
    agree(&compare(scene, &reference, 1), usize::MAX, 1e-6, 0.0);
}

#[test]
fn the_gripper_with_linear_elements() {
    gripper_at_rest(1);
}

#[test]
#[ignore = "half a minute: runs in make test-all"]
fn the_gripper_with_quadratic_elements() {
    gripper_at_rest(2);
}

#[test]
#[ignore = "a minute: runs in make test-all"]
fn the_gripper_begins_to_swell() {
    let Some(reference) = reference("gripper_dyn_step1") else { return };
    let file = "gripper_bellows/state_gripper_bellows.json";
    let Some((_dir, scene)) = scene(file, &Options::default()) else { return };
    agree(&compare(scene, &reference, 1), usize::MAX, 1e-6, 0.0);
}

/// Until the legs touch the ground in step 5. In a slab the field may vary
/// over the depth, where theirs may not: the less the thinner it is. The slab of the default
/// thickness goes the same way, and further, in the next test.
#[test]
fn the_walker_in_flight() {
    let Some(reference) = reference("walker_dyn50") else { return };
    let file = "walker/state_walker.json";
    let options = Options { form: None, thickness: Some(3e-4) };
    let Some((_dir, scene)) = scene(file, &options) else { return };
    agree(&compare(scene, &reference, 4), usize::MAX, 2e-6, 0.0);
}

/// Largest difference of what `of` measures of all steps in contact, over its
/// largest value.
fn apart(steps: &[Compared], of: impl Fn(&Touch) -> f64) -> f64 {
    let touching = || steps.iter().filter(|s| s.touch.iter().all(|t| t.gap.is_some()));
    let both = || touching().map(|s| s.touch.each_ref().map(&of));
    let largest = both().map(|[_, theirs]| theirs.abs()).fold(0.0, f64::max);
    both().map(|[ours, theirs]| (ours - theirs).abs()).fold(0.0, f64::max) / largest
}

/// Draws what `of` measures of every step, ours and theirs.
fn picture(name: &str, y: &str, steps: &[Compared], of: impl Fn(&Touch) -> Option<f64>) {
    let curve = |which: usize| -> Vec<(f64, f64)> {
        let point = |s: &Compared| Some((s.step as f64, of(&s.touch[which])?));
        steps.iter().filter_map(point).collect()
    };
    let one = |which: usize, label: &str, style: Style| Series {
        label: Some(label.to_owned()),
        points: curve(which),
        style,
        turn: which,
    };
    let series =
        [one(1, "PolyFEM, in the plane", Style::Circles(5)), one(0, "slab", Style::Dotted(2))];
    let axes = Axes { x: "time step of 20 ms".to_owned(), y: y.to_owned(), ..Axes::default() };
    draw(&repository().join("build").join(name), &axes, &series).unwrap();
}

#[test]
#[ignore = "a minute, and draws build/walker-force.svg and -gap.svg: runs in make test-all"]
fn the_walker_on_its_way() {
    let Some(reference) = reference("walker_dyn50") else { return };
    let file = "walker/state_walker.json";
    let Some((_dir, scene)) = scene(file, &Options::default()) else { return };
    let activation = scene.config.contact().unwrap().activation.unwrap();
    let steps = compare(scene, &reference, 50);
    agree(&steps, 5, 1e-4, 1e-2);
    let force = apart(&steps, |t| t.force.y);
    let gap = apart(&steps, |t| t.gap.unwrap());
    eprintln!("force off by {force:.2e} of the largest, gap by {gap:.2e}");
    assert!(force < 0.02, "{force:e}");
    let up = "force of contact [N per metre of depth]";
    picture("walker-force.svg", up, &steps, |t| Some(t.force.y));
    picture("walker-gap.svg", "smallest gap / activation", &steps, |t| Some(t.gap? / activation));
}

#[test]
#[ignore = "two minutes: runs in make test-all"]
fn the_worm_falls_and_lands() {
    let Some(reference) = reference("worm_dyn_steps1to2") else { return };
    let file = "worm/state_worm.json";
    let Some((_dir, scene)) = scene(file, &Options::default()) else { return };
    let steps = compare(scene, &reference, 2);
    agree(&steps, 2, 1e-9, 1e-6);
    let [force, gap] = [apart(&steps, |t| t.force.z), apart(&steps, |t| t.gap.unwrap())];
    eprintln!("force off by {force:.1e}, gap by {gap:.1e}");
    assert!(force < 1e-6 && gap < 1e-6, "{force:e} {gap:e}");
}

#[test]
fn what_cannot_be_imported_leaves_nothing_behind() {
    for (file, words) in [
        (
            "frog/state_frog_quasistatic.json",
            &["state_frog_quasistatic.json", "frog_base_mesh.msh"],
        ),
        ("finger/state_finger.json", &["state_finger.json", "finger_base_mesh.msh"]),
    ] {
        let Some(path) = tests::shared(&format!("{FOLDER}/{file}")) else { return };
        let dir = Workdir::new();
        let run = dir.solver(&format!("import {} -o out", path.display()));
        run.assert_refused(2, words);
        run.assert_refused(2, &["/geometry/0/mesh: there is no file", "put it there"]);
        assert_eq!(dir.files("out"), [""; 0]);
    }
    let dir = Workdir::new();
    for (text, words) in [("{", "bad.json: not JSON"), ("[1]", "bad.json: a list or a value")] {
        dir.write("bad.json", text);
        dir.solver("import bad.json -o out").assert_refused(2, &[words]);
    }
    dir.solver("import absent.json -o out").assert_refused(2, &["absent.json"]);
}

#[test]
fn the_program_warns_and_writes_what_it_says() {
    let Some(path) = tests::shared(&format!("{FOLDER}/walker/state_walker.json")) else { return };
    let dir = Workdir::new();
    let run = dir.solver(&format!("import {} -o out --thickness 0.01", path.display()));
    run.assert_good();
    for words in ["/solver/linear/solver", "0.010000 m thick", "wrote out/sim.toml"] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    let names = ["import.report.json", "sim.toml", "square.msh", "walker.msh"];
    assert_eq!(dir.files("out"), names);
}
