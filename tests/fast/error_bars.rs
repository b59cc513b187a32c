//! Error bars of probes: derivatives against simulations with the number changed, and reports.

use std::collections::BTreeMap;
use std::path::Path;

use measure::probe::measure;
use mechanics::extension::Extension;
use mechanics::forward::TimeStepper;
use mesh::Vec3;
use mesh::offset::shifts;
use scene::Scene;
use tests::chamber::{self, PRESSURE};
use tests::workdir::Workdir;

const MORE: &str = r#"
gravity = [0, 0, -9.81]
degree = 1

[[probe]]
name = "held"
kind = "reaction"
on = "seat"
axis = [1, 0, 0]

[uncertainty]
modulus = 0.04
wall = 0.05e-3
pressure = 200
density = 0.3
"#;

/// Motion through time, so that the past counts.
const TIME: &str = "[time]\nend = 0.02\nsteps = 2\nmethod = \"implicit-euler\"\n";

/// A scene whose probes have error bars, in a folder of its own.
pub fn workdir(time: &str) -> Workdir {
    let dir = chamber::workdir();
    let (mesh, tables) = chamber::SIM.split_once("degree = 2").unwrap();
    let tables = tables.replace("d1 = 1e6", "d1 = 1e6\ndensity = 1070");
    let (keys, probes) = MORE.split_once("\n\n").unwrap();
    let tight = "[solver]\nrelative_tolerance = 1e-13\nabsolute_tolerance = 1e-12\n";
    let common = chamber::PROBES;
    dir.write("sim.toml", &format!("{mesh}{keys}\n{tables}\n{common}\n{probes}\n{time}{tight}"));
    dir
}

/// Values of the probes of a scene.
fn simulate(scene: &Scene) -> BTreeMap<String, f64> {
    let (problem, mut workspace) = scene.problem(&scene.body).unwrap();
    let probes = scene.probes(&scene.body, &problem.space).unwrap();
    let integrator = scene.integrator(&scene.body, &problem);
    let mut stepper = TimeStepper::new(scene.stepping(), integrator);
    let rest = &scene.body.mesh.vertices;
    for end in scene.times() {
        stepper.advance(&problem, &mut workspace, rest, end, |_| ()).unwrap();
    }
    measure(&probes, &problem, &stepper.iterate(&problem, rest))
}

/// The scene with a number changed.
fn changed(path: &Path, of: &str, on: Option<&str>, by: f64) -> Scene {
    let mut scene = Scene::read(path).unwrap();
    let material = &mut scene.laws[0].material;
    match of {
        "modulus" => material.values.iter_mut().for_each(|p| *p *= 1.0 + by),
        "density" => material.density = material.density.map(|d| d * (1.0 + by)),
        "pressure" => {
            let text = std::fs::read_to_string(path).unwrap();
            let other = path.with_file_name("other.toml");
            let (old, new) = ("pressure = 8e3", format!("pressure = {:e}", PRESSURE + by));
            assert!(text.contains(old));
            std::fs::write(&other, text.replacen(old, &new, 1)).unwrap();
            scene = Scene::read(&other).unwrap();
        }
        "wall" => {
            let body = &scene.body;
            let facets =
                on.map_or_else(|| body.boundary().to_vec(), |tag| body.facets(tag).unwrap());
            let mut moves = vec![Vec3::zeros(); body.mesh.vertices.len()];
            for (v, d) in shifts(&body.mesh.vertices, &facets) {
                moves[v] = by * d;
            }
            Extension::new(body).unwrap().apply(&mut moves);
            scene.body.mesh.vertices.iter_mut().zip(&moves).for_each(|(x, d)| *x += d);
        }
        other => panic!("{other}"),
    }
    scene
}

/// The remainder of each derivative falls with the square of the change.
fn taylor(time: &str) {
    let dir = workdir(time);
    dir.solver("simulate sim.toml -o out").assert_good();
    let found = &dir.json("out/report.json")["error_bars"];
    let path = dir.path("sim.toml");
    let nominal = simulate(&Scene::read(&path).unwrap());
    let bars = found["top"]["bars"].as_array().unwrap();
    assert_eq!(bars.len(), 8, "four numbers, and the wall of four tags");
    let mut measured = 0;
    for (i, bar) in bars.iter().enumerate() {
        let (of, on) = (bar["of"].as_str().unwrap(), bar["on"].as_str());
        let off = bar["off"][1].as_f64().unwrap();
        let steps = [off / 8.0, off / 16.0];
        let runs = steps.map(|by| simulate(&changed(&path, of, on, by)));
        for (probe, value) in &nominal {
            let derivative = found[probe]["bars"][i]["derivative"].as_f64().unwrap();
            let [whole, half] =
                [0, 1].map(|i| (runs[i][probe] - value - steps[i] * derivative).abs());
            let slope = (whole / half).log2();
            // what is within rounding has no slope, such as a force that is linear in the number
            let rounding = 1e-10 * value.abs();
            measured += usize::from(whole > rounding);
            assert!(
                (slope - 2.0).abs() < 0.1 || whole < rounding,
                "{probe} by {of} {on:?}: slope {slope:.3}, remainders {whole:e} and {half:e} of {:e}",
                steps[0] * derivative
            );
        }
    }
    assert!(measured >= 10, "only {measured} of 24 remainders could be measured");
}

#[test]
fn derivatives_of_a_static_scene_are_those_of_other_scenes() {
    taylor("");
}

#[test]
fn derivatives_of_a_motion_are_those_of_other_motions() {
    taylor(TIME);
}

#[test]
fn derivatives_of_a_viscous_motion_are_those_of_other_motions() {
    taylor(&format!("{TIME}\n[[relaxation]]\noverstress = 0.5\ntime = 0.01\n"));
}

/// What the material is known to soften by goes one way, with the derivative by the modulus; creep that
/// is simulated is no error.
#[test]
fn softening_of_the_material_has_bars() {
    let dir = workdir(TIME);
    let sound = dir.text("sim.toml");
    let soft = sound.replacen("d1 = 1e6", "d1 = 1e6\ncreep = 0.25\nmullins = 0.1", 1);
    let bars = |scene: &str| {
        dir.write("sim.toml", scene);
        dir.solver("simulate sim.toml -o out --restart").assert_good();
        let report = dir.json("out/report.json");
        report["error_bars"]["top"]["bars"].as_array().unwrap().clone()
    };
    let of = |bars: &[serde_json::Value], of: &str| bars.iter().find(|b| b["of"] == of).cloned();
    assert!(of(&bars(&sound), "creep").is_none());
    let found = bars(&soft);
    let [modulus, creep, mullins] =
        ["modulus", "creep", "mullins"].map(|name| of(&found, name).unwrap());
    for (bar, off) in [(creep, 1.0 / 1.25 - 1.0), (mullins, -0.1)] {
        assert_eq!(bar["derivative"], modulus["derivative"]);
        assert!((bar["off"][0].as_f64().unwrap() - off).abs() < 1e-15, "{bar}");
        assert_eq!(bar["off"][1], 0.0);
        let change = bar["derivative"].as_f64().unwrap() * off;
        assert!((bar["change"][0].as_f64().unwrap() / change - 1.0).abs() < 1e-12, "{bar}");
    }
    let found = bars(&format!("{soft}\n[[relaxation]]\noverstress = 0.25\ntime = 0.01\n"));
    assert!(of(&found, "creep").is_none() && of(&found, "mullins").is_some());
}

#[test]
fn bars_are_derivatives_times_what_the_numbers_are_off() {
    let dir = workdir("");
    let run = dir.solver("simulate sim.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("error bars, to first order"), "{}", run.stderr);
    let report = dir.json("out/report.json");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    for (name, found) in report["error_bars"].as_object().unwrap() {
        assert!(
            (number(&found["value"]) / number(&report["probes"][name]["value"]) - 1.0).abs() < 1e-9
        );
        let mut sum = 0.0_f64;
        for bar in found["bars"].as_array().unwrap() {
            let change = number(&bar["derivative"]) * number(&bar["off"][1]);
            assert!((change - number(&bar["change"][1])).abs() <= 1e-12 * change.abs());
            sum += if bar["on"].is_null() { change * change } else { 0.0 };
        }
        assert!((number(&found["together"]) / sum.sqrt() - 1.0).abs() < 1e-12);
    }
    let largest = run.stderr.find("pressure").unwrap();
    assert!(largest < run.stderr.find("density").unwrap(), "the largest stands first");
}
