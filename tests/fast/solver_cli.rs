//! `solver simulate`, by the program, on scenes without mistakes.

use std::process::Command;

use mesh::io::npy;
use serde_json::Value;
use tests::chamber::{self, MOUTH, PRESSURE};
use tests::reported::number;
use tests::workdir::{Workdir, python};

fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|k| number(&value[k]))
}

/// A folder with the results of `scene` in `out`.
fn simulated(scene: &str) -> (Workdir, Value) {
    let dir = chamber::workdir();
    let report = dir.report(&format!("simulate {scene} -o out"));
    (dir, report)
}

/// Scripts rely on these keys; the chapter "Results" of the book lists them.
#[test]
fn the_report_has_what_is_documented() {
    for (scene, dofs) in [("p1.toml", 438), ("sim.toml", 2457)] {
        let (dir, report) = simulated(scene);
        assert_eq!(report["status"], "ok");
        // 146 vertices; 819 nodes with those on edges
        assert_eq!((&report["dofs"], &report["tets"]), (&dofs.into(), &384.into()));
        for key in ["newton_iterations", "wall_s", "peak_rss_mb"] {
            assert!(number(&report[key]) > 0.0, "{key} = {}", report[key]);
        }
        for key in ["elastic", "chamber", "total"] {
            assert!(number(&report["energies"][key]) != 0.0, "energies.{key}");
        }
        assert_eq!(report["tags"].as_object().unwrap().len(), 4);
        for (tag, area) in [("seat", 12e-4), ("cavity", 36e-4), ("top", 20e-4), ("skin", 76e-4)] {
            let found = &report["tags"][tag];
            assert!((number(&found["area"]) / area - 1.0).abs() < 1e-12, "{tag} {found}");
            let (mean, max) = (number(&found["mean_displacement"]), &found["max_displacement"]);
            // fixed means exactly fixed, and everything else moves
            assert!(if tag == "seat" { number(max) == 0.0 } else { 0.0 < mean }, "{tag} {found}");
            assert!(mean <= number(max), "{tag} {found}");
            vector(&found["reaction"]);
        }
        let wall = &report["chambers"]["cavity"];
        assert_eq!(number(&wall["pressure"]), PRESSURE);
        assert!(number(&wall["volume"]) > number(&wall["volume_rest"]), "{wall}");
        let mut expected = vec!["curve.csv", "displacement.npy", "nodes.npy", "report.json"];
        expected.extend(["result.pvd", "result.vtu"]);
        let steps = report["steps"].as_array().unwrap().len();
        let steps: Vec<String> = (0..steps).map(|i| format!("step_{i:03}.vtu")).collect();
        expected.extend(steps.iter().map(String::as_str));
        expected.push("steps.jsonl");
        assert_eq!(dir.files("out"), expected);
    }
}

/// For the trapezoidal rule, by which the work of loads is computed.
const THREE_STEPS: &str = "\n[solver]\nlargest_load_step = 0.375\n";

/// The rim of the mouth cannot move, so whatever the wall does the gas pushes
/// with the pressure times the area of the mouth, and only the seat holds it.
#[test]
fn reactions_balance_the_gas() {
    let dir = chamber::workdir();
    dir.write("steps.toml", &format!("{}{THREE_STEPS}", dir.text("sim.toml")));
    let report = dir.report("simulate steps.toml -o out");
    let force = PRESSURE * MOUTH * MOUTH;
    // equilibrium is sought to 1e-10 of the forces
    let near = |found: &Value, expected: [f64; 3]| {
        let differs = vector(found).iter().zip(expected).any(|(f, e)| (f - e).abs() > 1e-9 * force);
        assert!(!differs, "{found} is not {expected:?}");
    };
    near(&report["force_balance"]["chamber"], [force, 0.0, 0.0]);
    near(&report["tags"]["seat"]["reaction"], [-force, 0.0, 0.0]);
    assert!(number(&report["force_balance"]["out_of_balance"]) < 1e-9 * force);
    // work of the gas by the trapezoidal rule over three load steps
    assert!(number(&report["energy_balance"]["relative_gap"]).abs() < 0.01);
    let energies = &report["energies"];
    let sum = number(&energies["elastic"]) + number(&energies["chamber"]);
    assert!((sum - number(&energies["total"])).abs() < 1e-15);
    // −P ΔV is the potential of the gas
    let wall = &report["chambers"]["cavity"];
    let swelling = number(&wall["volume"]) - number(&wall["volume_rest"]);
    let gap = number(&energies["chamber"]) / (-PRESSURE * swelling) - 1.0;
    assert!(gap.abs() < 1e-9, "{gap}");
}

#[test]
fn arrays_hold_the_state_of_the_report() {
    let (dir, report) = simulated("sim.toml");
    let (nodes, shape) = npy::read_f64(&dir.path("out/nodes.npy")).unwrap();
    assert_eq!(shape, [819, 3]);
    // vertices come first, with the bits of the mesh
    let body = chamber::chamber();
    for (v, position) in body.mesh.vertices.iter().enumerate() {
        assert_eq!(nodes[3 * v..3 * v + 3], position.as_slice()[..]);
    }
    let (u, shape) = npy::read_f64(&dir.path("out/displacement.npy")).unwrap();
    assert_eq!(shape, [819, 3]);
    let largest = u.chunks(3).map(|u| u.iter().map(|c| c * c).sum::<f64>().sqrt());
    let largest = largest.fold(0.0, f64::max);
    let tags = report["tags"].as_object().unwrap();
    let reported = tags.values().map(|t| number(&t["max_displacement"])).fold(0.0, f64::max);
    assert!((largest / reported - 1.0).abs() < 1e-14, "{largest} {reported}");
}

/// Another program reads the same state from the picture file.
#[test]
fn meshio_reads_the_result() {
    const READ: &str = "
import json, sys, meshio, numpy
folder, kind = sys.argv[1:]
mesh = meshio.read(folder + '/result.vtu')
assert [(c.type, len(c.data)) for c in mesh.cells] == [(kind, 384)], mesh
[u] = [u for name, u in mesh.point_data.items() if name.split(' [')[0] == 'displacement']
assert numpy.array_equal(u, numpy.load(folder + '/displacement.npy'))
assert numpy.array_equal(mesh.points, numpy.load(folder + '/nodes.npy'))
cells = {name: data for name, [data] in mesh.cell_data.items()}
for name in ['stretch', 'von_mises', 'hydrostatic_pressure', 'nominal_stress', 'strain_energy']:
    low, high = cells[name].min(), cells[name].max()
    assert low < mesh.point_data[name].mean() < high, name
stress = cells['cauchy_stress'].reshape(-1, 3, 3)
pressure = -numpy.trace(stress, axis1=1, axis2=2) / 3
assert numpy.allclose(pressure, cells['hydrostatic_pressure'], rtol=1e-12)
largest = json.load(open(folder + '/report.json'))['stretch_range']['largest']
assert 1.0 < cells['stretch'].max() < largest + 1e-12, (cells['stretch'].max(), largest)
";
    let Some(python) = python("meshio, numpy") else { return };
    for (scene, kind) in [("p1.toml", "tetra"), ("sim.toml", "tetra10")] {
        let (dir, _) = simulated(scene);
        let output = Command::new(&python)
            .args(["-c", READ])
            .arg(dir.path("out"))
            .arg(kind)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// One state per time step, whatever load steps it takes; ParaView shows them at
/// their times.
#[test]
fn a_scene_with_time_has_one_result_per_time_step() {
    let dir = chamber::workdir();
    let pressure = "{ t = [0, 0.2, 1], value = [0, 8e3, 2e3] }";
    let scene = dir.text("p1.toml").replace("8e3", pressure)
        + "[time]\nmethod = \"quasistatic\"\nat = [0.1, 0.2, 0.6, 1]\n";
    dir.write("timed.toml", &scene);
    let report = dir.report("simulate timed.toml -o out");
    let steps = report["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 4);
    for (step, (t, pressure)) in steps.iter().zip([(0.1, 4e3), (0.2, 8e3), (0.6, 5e3), (1.0, 2e3)])
    {
        assert_eq!(number(&step["t"]), t);
        assert!(step["load"].is_null(), "there is no full load");
        let wall = &step["chambers"]["cavity"];
        assert!((number(&wall["pressure"]) / pressure - 1.0).abs() < 1e-12, "{wall}");
        for key in ["newton_iterations", "residual", "smallest_volume_ratio"] {
            assert!(number(&step[key]) > 0.0, "{key}");
        }
        assert!(number(&step["energies"]["elastic"]) > 0.0);
        let reaction = vector(&step["reactions"]["seat"])[0];
        assert!((reaction / (-pressure * MOUTH * MOUTH) - 1.0).abs() < 1e-6, "{reaction}");
        assert!(number(&step["force_balance"]["out_of_balance"]) < 1e-9);
    }
    // the last state is the result
    assert!((number(&report["chambers"]["cavity"]["pressure"]) / 2e3 - 1.0).abs() < 1e-12);
    assert!(number(&report["energy_balance"]["relative_gap"]).abs() < 0.05);
    assert_eq!(report["config"]["chamber"][0]["pressure"]["value"][1], 8e3);
    let pvd = dir.text("out/result.pvd");
    for (i, t) in ["0.1", "0.2", "0.6", "1.0"].iter().enumerate() {
        let entry = format!("timestep=\"{t}\" part=\"0\" file=\"step_{i:03}.vtu\"");
        assert!(
            pvd.contains(&entry) && dir.path(&format!("out/step_{i:03}.vtu")).exists(),
            "{pvd}"
        );
    }
    assert!(!dir.path("out/step_004.vtu").exists());
}

/// An open wall with a plug: the pressure that its volume needs is reported.
#[test]
fn a_prescribed_volume_reports_its_pressure() {
    let dir = chamber::workdir();
    let pressure = "[[chamber]]\non = \"cavity\"\npressure = 8e3";
    let volume = "[[chamber]]\non = \"cavity\"\nvolume_change = 1e-6";
    let scene = dir.text("sim.toml").replace(pressure, volume) + THREE_STEPS;
    dir.write("volume.toml", &scene);
    let report = dir.report("simulate volume.toml -o out");
    let wall = &report["chambers"]["cavity"];
    let change = number(&wall["volume"]) - number(&wall["volume_rest"]);
    assert!((change / 1e-6 - 1.0).abs() < 1e-8, "{wall}");
    let pressure = number(&wall["pressure"]);
    let force = vector(&report["force_balance"]["chamber"])[0];
    assert!(pressure > 1e3 && (force / (pressure * MOUTH * MOUTH) - 1.0).abs() < 1e-8, "{wall}");
    // the work done on the volume is the elastic energy
    assert!(number(&report["energy_balance"]["relative_gap"]).abs() < 0.01);
    assert!(number(&report["energies"]["chamber"]).abs() < 1e-8 * pressure * 1e-6);
}

#[test]
fn options_change_what_is_written() {
    let dir = chamber::workdir();
    dir.solver("simulate p1.toml -o out -q").assert_good();
    let all = dir.files("out").len();
    // a second run replaces the files of the first
    let run = dir.solver(
        "--threads 1 simulate p1.toml -o out --final-only -q --set solver.locking=\"never\"",
    );
    run.assert_good();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    let files = dir.files("out");
    assert!(files.len() < all && !files.iter().any(|f| f.starts_with("step_")), "{files:?}");
    assert!(!files.contains(&"result.pvd".to_owned()));
    // another mesh in place of the scene's, and a folder that is made with its parents
    std::fs::rename(dir.path("body.msh"), dir.path("other.msh")).unwrap();
    dir.solver("simulate p1.toml --mesh other.msh -o deep/out").assert_good();
    assert_eq!(dir.json("deep/out/report.json")["status"], "ok");
}

/// Growth of oscillations of which `bdf3` warns shows in the energy; generalized-α adds next to none.
#[test]
fn the_energy_that_steps_add_is_reported() {
    let dir = chamber::workdir();
    let scene = dir.text("p1.toml").replace("d1 = 1e6", "d1 = 1e6\ndensity = 1000");
    let gain = |method: &str| {
        let time = format!("\n[time]\nend = 0.1\nsteps = 100\nmethod = \"{method}\"\n");
        dir.write("blown.toml", &(scene.clone() + &time));
        let run = dir.solver(&format!("simulate blown.toml -o {method} --final-only"));
        run.assert_good();
        let report = dir.json(&format!("{method}/report.json"));
        let gain = report["energy_balance"]["largest_gain"].as_f64().unwrap();
        let warned = run.stderr.contains("add energy");
        assert_eq!(warned, gain > 0.1, "{gain} {}", run.stderr);
        gain
    };
    let (grows, stays) = (gain("bdf3"), gain("generalized-alpha"));
    assert!(grows > 0.1, "{grows}");
    assert!(stays < 0.05, "{stays}");
}
