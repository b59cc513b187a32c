//! What contact leaves open, surfaces that cross or will meet, and runs through time that fail: exit code, a message with
//! numbers, the good part on disk.

use mesh::io::{write_surface, write_tets};
use serde_json::Value;
use tests::workdir::{Run, Workdir};
use tests::{block, tag};

use crate::samples::{SOLID, falling};

#[test]
fn an_obstacle_in_millimetres_is_refused() {
    let dir = falling();
    let mut floor = mesh::io::read_surface(&dir.path("floor.stl")).unwrap();
    floor.vertices.iter_mut().for_each(|x| *x *= 1e3);
    write_surface(&dir.path("floor.stl"), &floor).unwrap();
    let run = dir.solver("simulate p1.toml -o out");
    run.assert_refused(2, &["floor.stl", "2900.", "cad2fem import FILE --unit mm"]);
}

/// Without contact a block is led into another one: the run ends, and says that it is not usable.
#[test]
fn surfaces_that_run_through_each_other_without_contact() {
    let dir = falling();
    let scene = |way: f64, contact: &str| {
        format!(
            "degree = 1\n{contact}\n\
             [[body]]\nname = \"a\"\nmesh = \"block.msh\"\n{SOLID}\
             [[body]]\nname = \"b\"\nmesh = \"block.msh\"\ntranslate = [0.02, 1e-3, 1e-3]\n{SOLID}\
             [[fixed]]\non = \"a\"\n\
             [[fixed]]\non = \"b\"\ndisplacement = [\"-{way}*t\", 0, 0]\n"
        )
    };
    dir.write("apart.toml", &scene(9e-3, ""));
    dir.solver("simulate apart.toml -o apart").assert_good();
    let report = dir.json("apart/report.json");
    assert!(report["usable"] == true && report["crossing"].is_null(), "{report}");

    dir.write("through.toml", &scene(12e-3, ""));
    let run = dir.solver("simulate through.toml -o out");
    run.assert_refused(1, &["pairs of triangles", "\"a\" and \"b\"", "contact = \"ignored\""]);
    // the gap of 10 mm is closed where supports have gone 10 of 12 mm
    run.assert_refused(1, &["will meet: 10.00 mm apart", "they close that at 83 % of the load"]);
    let report = dir.json("out/report.json");
    assert_eq!((&report["usable"], &report["status"]), (&false.into(), &"surfaces_crossed".into()));
    let crossing = &report["crossing"];
    assert!(crossing["pairs"].as_u64().unwrap() > 4, "{crossing}");
    // b has its left face at 8 mm then
    let x = crossing["place"][0].as_f64().unwrap();
    assert!((5e-3..13e-3).contains(&x), "{crossing}");
    // what was computed is there to be looked at
    assert!(dir.path("out/result.vtu").is_file());

    dir.write("ignored.toml", &scene(12e-3, "contact = \"ignored\""));
    dir.solver("simulate ignored.toml -o ignored").assert_good();
    assert_eq!(dir.json("ignored/report.json")["usable"], true);
    dir.write("word.toml", &scene(12e-3, "contact = \"none\""));
    dir.solver("simulate word.toml -o none").assert_refused(2, &["word.toml:2", "\"ignored\""]);
}

/// A block that is pulled towards another one, 0.8 mm away: linear elasticity closes the gap at about half of the load.
/// The line that is proposed is enough.
#[test]
fn surfaces_that_will_meet_are_said_before_the_run() {
    let dir = falling();
    let cube = block([2, 2, 2], 5e-3, |_| false, |p| p);
    let cube =
        tag(cube, &[("low", &|p| p.x < 1e-9), ("high", &|p| p.x > 9.999e-3), ("skin", &|_| true)]);
    write_tets(&dir.path("block.msh"), &cube.mesh, &cube.tags).unwrap();
    let scene = |pull: f64, contact: &str| {
        format!(
            "degree = 1\n{contact}\n\
             [[body]]\nname = \"a\"\nmesh = \"block.msh\"\n{SOLID}\
             [[body]]\nname = \"b\"\nmesh = \"block.msh\"\ntranslate = [10.8e-3, 0, 0]\n{SOLID}\
             [[fixed]]\non = \"a\"\n[[fixed]]\non = \"b.high\"\n\
             [[traction]]\non = \"b.low\"\ntraction = [{pull:?}, 0, 0]\n"
        )
    };
    dir.write("pulled.toml", &scene(-16e3, ""));
    let run = dir.solver("simulate pulled.toml -o pulled");
    run.assert_refused(
        1,
        &["\"b.low\" and \"a.high\" will meet: 0.80 mm apart", "add the line [contact]"],
    );
    let (_, load) = run.stderr.split_once("they close that at ").unwrap();
    let load: f64 = load.split(' ').next().unwrap().parse().unwrap();
    assert!((40.0..65.0).contains(&load), "{load}");
    for (name, pull, contact) in
        [("less", -4e3, ""), ("apart", 16e3, ""), ("held", -16e3, "contact = {}")]
    {
        dir.write(&format!("{name}.toml"), &scene(pull, contact));
        let run = dir.solver(&format!("simulate {name}.toml -o {name}"));
        run.assert_good();
        assert!(!run.stderr.contains("will meet"), "{name}: {}", run.stderr);
    }
}

/// Runs a scene that must fail during the run; the report, with as many lines in
/// steps.jsonl and pictures as time steps were done.
fn fails(dir: &Workdir, scene: &str, words: &[&str]) -> (Run, Value) {
    let run = dir.solver(&format!("simulate {scene} -o out"));
    run.assert_refused(1, words);
    run.assert_refused(1, &[scene, "no equilibrium beyond t = ", "not_full_load.vtu"]);
    let report = dir.json("out/report.json");
    assert_eq!(report["usable"], false);
    let steps = report["steps"].as_array().unwrap();
    assert!(!steps.is_empty());
    assert_eq!(&dir.lines("out/steps.jsonl"), steps);
    let files = dir.files("out");
    let pictures = files.iter().filter(|f| f.starts_with("step_")).count();
    assert_eq!(pictures, steps.len(), "{files:?}");
    for name in ["not_full_load.vtu", "result.pvd"] {
        assert!(files.contains(&name.to_owned()), "{files:?}");
    }
    for name in ["result.vtu", "displacement.npy", "checkpoint.json"] {
        assert!(!files.contains(&name.to_owned()), "{files:?}");
    }
    (run, report)
}

#[test]
fn a_step_that_cannot_converge() {
    let dir = falling();
    let impatient = "[solver]\nnewton_iterations = 1\nsmallest_load_step = 0.2\n[time]";
    dir.write("one.toml", &dir.text("p1.toml").replace("[time]", impatient));
    let (_, report) = fails(&dir, "one.toml", &["1 Newton iterations were not enough", "wanted"]);
    // it falls 1.9 mm in 20 ms
    let reached = report["failure"]["load_reached"].as_f64().unwrap();
    assert!((0.015..0.04).contains(&reached), "{reached}");
    // once it is repaired, the run in the same folder succeeds
    dir.solver("simulate p1.toml -o out").assert_good();
    assert!(!dir.files("out").contains(&"not_full_load.vtu".to_owned()));
    assert_eq!(dir.json("out/report.json")["steps"].as_array().unwrap().len(), 10);
}
