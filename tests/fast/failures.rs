//! `solver` where there is no equilibrium, or none to the tolerance that is required, where surfaces cross or will meet, and
//! where runs through time fail: exit code, what the message and report.json say, and the last good state on disk.

use std::process::Command;

use mesh::Vec3;
use mesh::io::write_surface;
use serde_json::Value;
use tests::chamber::{self, SIM, beyond_any_equilibrium};
use tests::reported::number;
use tests::workdir::{Run, Workdir};
use tests::{block, tag};

use crate::samples::{SOLID, falling};

/// Runs a scene that must fail; its report.
fn failing(dir: &Workdir, scene: &str) -> (Run, Value) {
    let run = dir.solver(&format!("simulate {scene} -o out"));
    run.assert_refused(1, &[scene, "not_full_load.vtu", "worst element: tetrahedron"]);
    let mut files = dir.files("out");
    // the load steps that were made, of which there may be none
    files.retain(|name| !name.starts_with("step") && name != "result.pvd" && name != "curve.csv");
    assert_eq!(files, ["not_full_load.vtu", "report.json"]);
    let report = dir.json("out/report.json");
    assert_eq!(report["usable"], false);
    (run, report)
}

#[test]
fn a_failure_names_what_was_reached_and_where() {
    let dir = chamber::workdir();
    dir.write("high.toml", &beyond_any_equilibrium(&dir.text("p1.toml")));
    let (run, report) = failing(&dir, "high.toml");
    assert_eq!(report["status"], "no equilibrium");
    let failure = &report["failure"];
    assert!(number(&failure["load_reached"]) < number(&failure["load_tried"]));
    assert!(failure["residuals"].as_array().unwrap().len() <= 8, "{failure}");
    let worst = &failure["worst_element"];
    let id = usize::try_from(worst["id"].as_u64().unwrap()).unwrap();
    let body = chamber::chamber();
    let centre = body.mesh.corners(id).iter().sum::<Vec3>() / 4.0;
    let reported = [0, 1, 2].map(|k| number(&worst["at"][k]));
    assert!((centre - Vec3::from(reported)).norm() < 1e-15, "{worst}");
    // the corner tetrahedra of a cube: r/R of the path-shaped one
    assert!(number(&worst["quality"]) > 0.5, "{worst}");
    run.assert_refused(1, &[&format!("tetrahedron {id} "), "residuals at", "try: "]);
    let advice = failure["try"].as_array().unwrap();
    assert!(!advice.is_empty());
    advice.iter().for_each(|a| run.assert_refused(1, &[a.as_str().unwrap()]));
}

/// A column of silicone under a mass, of 10 × 10 × 70 mm, gives way near Euler's load π² E I/4L²: 8.6 % of the weight,
/// with its own. Newton's method crawls there, and does not come beyond.
#[test]
fn a_column_is_said_to_buckle_and_where() {
    let body = tag(
        block([2, 2, 14], 5e-3, |_| false, |p| p),
        &[("bottom", &|p| p.z < 1e-9), ("top", &|p| p.z > 0.07 - 1e-9), ("sides", &|_| true)],
    );
    let dir = Workdir::with(&body);
    let scene = "mesh = \"body.msh\"\ndegree = 2\ngravity = [0.02, 0, -9.81]\ncontact = \"ignored\"\n\
                 [material]\nkind = \"neo-hookean\"\nyoung = 200e3\npoisson = 0.45\ndensity = 1070\n\
                 [[fixed]]\non = \"bottom\"\n[[rigid]]\non = \"top\"\nmass = 0.1\n[solver]\nlargest_load_step = 0.1\n";
    let warns = |run: &Run, what: &str| {
        let said: Vec<&str> = run.stderr.split(what).skip(1).collect();
        assert!(!said.is_empty(), "{}", run.stderr);
        for said in said {
            let percent: f64 = said.split(' ').next().unwrap().parse().unwrap();
            assert!((8.0..9.5).contains(&percent), "{percent}");
        }
    };
    dir.write("fine.toml", &format!("{scene}smallest_load_step = 5e-4\n"));
    let run = dir.solver("simulate fine.toml -o bent");
    run.assert_good();
    warns(&run, "warning: the body buckles at about ");
    dir.write("column.toml", scene);
    let (run, _) = failing(&dir, "column.toml");
    run.assert_refused(1, &["\"arc-length\""]);
    warns(&run, "try: the body buckles at about ");
}

/// A box with walls of a sixth of its side: as rubber balloons do, it has a
/// largest pressure. The load steps come close to it, and the body then yields.
#[test]
fn a_balloon_is_told_from_a_bad_mesh() {
    let (run, report) = failing(&balloon(150e3), "sim.toml");
    run.assert_refused(1, &["balloons", "prescribe the volume", "times what it did at rest"]);
    assert!(number(&report["failure"]["softening"]) > 8.0, "{report}");
    assert!(number(&report["failure"]["softest_stiffness"]["at_rest"]) > 0.0, "{report}");
    assert!(number(&report["failure"]["load_reached"]) > 0.05, "{report}");
}

/// A folder with the box and its scene under a pressure [Pa].
fn balloon(pressure: f64) -> Workdir {
    let hollow = |c: [usize; 3]| c.iter().all(|&i| (1..5).contains(&i));
    let mesh = block([6, 6, 6], 1e-3, hollow, |p| p);
    let inner = |p: Vec3| p.iter().all(|&x| x > 0.5e-3 && x < 5.5e-3);
    let body = tag(mesh, &[("cavity", &inner), ("seat", &|p: Vec3| p.z < 1e-9)]);
    let dir = Workdir::with(&body);
    let law = "[material]\nkind = \"neo-hookean\"\nyoung = 3e5\npoisson = 0.45\n";
    let stepping = "[solver]\nnewton_iterations = 8\nsmallest_load_step = 0.02\n";
    let loads =
        format!("[[fixed]]\non = \"seat\"\n[[chamber]]\non = \"cavity\"\npressure = {pressure}\n");
    dir.write("sim.toml", &format!("mesh = \"body.msh\"\ndegree = 1\n{law}{loads}{stepping}"));
    dir
}

/// Nothing keeps the walls of an emptied chamber apart: finer steps do not help.
#[test]
fn a_vacuum_without_contact_is_told_to_have_one() {
    let dir = balloon(-150e3);
    let (run, _) = failing(&dir, "sim.toml");
    run.assert_refused(1, &["no equilibrium", "try: add [contact]"]);
    assert!(!run.stderr.contains("finer load steps"), "{}", run.stderr);
}

/// Two blocks that share an edge: the second turns about it.
#[test]
fn a_hinge_is_not_called_a_failure_to_converge() {
    // they lie on opposite sides of the edge x = z = 10 mm
    let mesh = block([4, 2, 4], 5e-3, |[x, _, z]| (x < 2) != (z < 2), |p| p);
    let body = tag(mesh, &[("seat", &|p: Vec3| p.z < 1e-9), ("top", &|p| p.z > 0.02 - 1e-9)]);
    let dir = Workdir::with(&body);
    let material = &SIM[SIM.find("[material]").unwrap()..SIM.find("[[fixed]]").unwrap()];
    let loads = "[[fixed]]\non = \"seat\"\n[[traction]]\non = \"top\"\ntraction = [100, 0, 0]\n";
    dir.write("sim.toml", &format!("mesh = \"body.msh\"\ndegree = 1\n{material}{loads}"));
    let (run, report) = failing(&dir, "sim.toml");
    assert_eq!(report["status"], "not enough supports");
    run.assert_refused(1, &["not enough supports", "moves without any force", "fix more tags"]);
    assert!(!run.stderr.contains("no equilibrium"), "{}", run.stderr);
}

/// Loads that hardly exceed rounding, on a body a hundred times as large, too: they are in
/// balance, or the report says how near.
#[test]
fn tiny_loads_of_gas_have_an_equilibrium() {
    let dir = chamber::workdir();
    let mut body = chamber::chamber();
    body.mesh.vertices.iter_mut().for_each(|x| *x *= 100.0);
    dir.put("large.msh", &body);
    let gas =
        |fill: f64, ambient: f64| format!("fill = {fill:e}\nambient = {ambient:e}\nexponent = 1.4");
    for load in [gas(1e-9, 101_325.0), gas(1e-3, 1e7), "volume_change = 1e-18".to_owned()] {
        for mesh in ["body.msh", "large.msh"] {
            let scene = dir.text("p1.toml").replace("body.msh", mesh);
            dir.write("sim.toml", &scene.replace("pressure = 8e3", &load));
            dir.solver("simulate sim.toml -o out").assert_good();
            assert_eq!(dir.json("out/report.json")["usable"], true, "{load}, {mesh}");
        }
    }
}

/// A tolerance below rounding: the result is as good as numbers allow, and says
/// that it is not what was asked for.
#[test]
fn a_tolerance_below_rounding_is_reported_as_missed() {
    let dir = chamber::workdir();
    let ask = |relative: &str| {
        format!("[solver]\nabsolute_tolerance = 0\nrelative_tolerance = {relative}\n[mat")
    };
    for scene in ["p1.toml", "sim.toml"] {
        let text = dir.text(scene);
        dir.write("asked.toml", &text.replacen("[mat", &ask("1e-18"), 1));
        dir.solver("simulate asked.toml -o out").assert_says(&["rounding alone may leave"]);
        let report = dir.json("out/report.json");
        assert_eq!(report["tolerance_met"], false);
        let last = report["steps"].as_array().unwrap().last().unwrap().clone();
        let [residual, wanted, floor] =
            ["residual", "residual_wanted", "rounding_floor"].map(|key| number(&last[key]));
        assert!(wanted < residual && residual < floor, "{last}");
        // the estimate is not so large that it would let anything pass
        assert!(floor < 1e-10 * 8e3 * 36e-4, "{last}");
        dir.write("asked.toml", &text.replacen("[mat", &ask("1e-10"), 1));
        let run = dir.solver("simulate asked.toml -o out");
        run.assert_good();
        assert!(!run.stderr.contains("rounding"), "{}", run.stderr);
        assert_eq!(dir.json("out/report.json")["tolerance_met"], true);
    }
}

/// A limit on the address space, as `ulimit -v` and batch systems set it.
#[test]
fn a_factor_that_does_not_fit_is_refused_before_it_is_made() {
    if !cfg!(target_os = "linux") {
        tests::skip::skip("limits of memory are read on Linux only");
        return;
    }
    let dir = chamber::workdir();
    let body = tag(block([14, 14, 14], 1e-3, |_| false, |p| p), &[("seat", &|p| p.z < 1e-9)]);
    dir.put("body.msh", &body);
    dir.write("sim.toml", &SIM[..SIM.find("[[chamber]]").unwrap()]);
    let solver = dir.command("simulate sim.toml -o out --threads 1");
    let mut limited = Command::new("bash");
    limited.args(["-c", "ulimit -v 600000; exec \"$0\" \"$@\""]).arg(solver.get_program());
    limited.args(solver.get_args()).current_dir(dir.path(""));
    let run: Run = limited.output().unwrap().into();
    let words = ["sim.toml", "unknowns", "million entries", "B are needed", "coarser mesh"];
    run.assert_refused(1, &words);
    assert!(!dir.path("out").exists());
}

#[test]
fn an_optimisation_whose_start_has_no_equilibrium() {
    let dir = chamber::workdir();
    let sound = dir.text("p1.toml");
    dir.write("p1.toml", &beyond_any_equilibrium(&sound));
    dir.solver("check design.toml").assert_refused(1, &["no equilibrium"]);
    dir.solver("optimize design.toml -o out")
        .assert_refused(1, &["level 1", "no equilibrium", "worst element: tetrahedron", "try: "]);
    let files = dir.files("out");
    assert!(files.contains(&"not_full_load.vtu".to_owned()), "{files:?}");
    let report = dir.json("out/report.json");
    assert_eq!((&report["usable"], &report["level"]), (&false.into(), &1.into()));
    // once it is repaired, it runs in the same folder, and no trace of the failure is left
    dir.write("p1.toml", &sound);
    dir.solver("optimize design.toml -o out").assert_good();
    assert!(!dir.files("out").contains(&"not_full_load.vtu".to_owned()));
    assert_eq!(dir.json("out/report.json")["usable"], true);
}

#[test]
fn an_obstacle_in_millimetres_is_refused() {
    let dir = falling();
    let mut floor = mesh::io::read_surface(&dir.path("floor.stl")).unwrap();
    floor.vertices.iter_mut().for_each(|x| *x *= 1e3);
    write_surface(&dir.path("floor.stl"), &floor).unwrap();
    dir.solver("simulate p1.toml -o out")
        .assert_refused(2, &["floor.stl", "2900.", "cad2fem import FILE --unit mm"]);
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
    let report = dir.report("simulate apart.toml -o apart");
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
    dir.put("block.msh", &cube);
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
