//! `solver` where there is no equilibrium, or none to the tolerance that is
//! required: exit code, what the message and report.json say, and the last good
//! state on disk.

use std::process::Command;

use mesh::io::write_tets;
use mesh::{TetMesh, Vec3};
use serde_json::Value;
use tests::chamber::{self, SIM, beyond_any_equilibrium};
use tests::reported::number;
use tests::workdir::{Run, Workdir};
use tests::{block, tag};

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
    let dir = Workdir::new();
    let body = tag(
        block([2, 2, 14], 5e-3, |_| false, |p| p),
        &[("bottom", &|p| p.z < 1e-9), ("top", &|p| p.z > 0.07 - 1e-9), ("sides", &|_| true)],
    );
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    dir.write(
        "column.toml",
        "mesh = \"body.msh\"\ndegree = 2\ngravity = [0.02, 0, -9.81]\n\
         [material]\nkind = \"neo-hookean\"\nyoung = 200e3\npoisson = 0.45\ndensity = 1070\n\
         [[fixed]]\non = \"bottom\"\n[[rigid]]\non = \"top\"\nmass = 0.1\n[solver]\nlargest_load_step = 0.1\n",
    );
    let (run, _) = failing(&dir, "column.toml");
    run.assert_refused(
        1,
        &["warning: the body buckles", "try: the body buckles", "\"arc-length\""],
    );
    for said in run.stderr.split("buckles at about ").skip(1) {
        let percent: f64 = said.split(' ').next().unwrap().parse().unwrap();
        assert!((8.0..9.5).contains(&percent), "{percent}");
    }
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
    let dir = Workdir::new();
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
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
    let first = block([2, 2, 2], 5e-3, |_| false, |p| p);
    let dir = hinged(&first);
    let (run, report) = failing(&dir, "sim.toml");
    assert_eq!(report["status"], "not enough supports");
    run.assert_refused(1, &["not enough supports", "moves without any force", "fix more tags"]);
    assert!(!run.stderr.contains("no equilibrium"), "{}", run.stderr);
}

fn hinged(first: &TetMesh) -> Workdir {
    // the copy lies on the other side of the edge x = z = 10 mm
    let shift = Vec3::new(0.01, 0.0, 0.01);
    let mut mesh = first.clone();
    let id: Vec<usize> = first
        .vertices
        .iter()
        .map(|v| {
            let moved = v + shift;
            let known = mesh.vertices.iter().position(|w| (w - moved).norm() < 1e-9);
            known.unwrap_or_else(|| {
                mesh.vertices.push(moved);
                mesh.vertices.len() - 1
            })
        })
        .collect();
    mesh.tets.extend(first.tets.iter().map(|tet| tet.map(|v| id[v])));
    let body = tag(mesh, &[("seat", &|p: Vec3| p.z < 1e-9), ("top", &|p| p.z > 0.02 - 1e-9)]);
    let dir = Workdir::new();
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    let material = &SIM[SIM.find("[material]").unwrap()..SIM.find("[[fixed]]").unwrap()];
    let loads = "[[fixed]]\non = \"seat\"\n[[traction]]\non = \"top\"\ntraction = [100, 0, 0]\n";
    dir.write("sim.toml", &format!("mesh = \"body.msh\"\ndegree = 1\n{material}{loads}"));
    dir
}

/// Loads that hardly exceed rounding, on a body a hundred times as large, too: they are in
/// balance, or the report says how near.
#[test]
fn tiny_loads_of_gas_have_an_equilibrium() {
    let dir = chamber::workdir();
    let mut body = chamber::chamber();
    body.mesh.vertices.iter_mut().for_each(|x| *x *= 100.0);
    write_tets(&dir.path("large.msh"), &body.mesh, &body.tags).unwrap();
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
        let run = dir.solver("simulate asked.toml -o out");
        run.assert_good();
        assert!(run.stderr.contains("rounding alone may leave"), "{}", run.stderr);
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
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
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
    let run = dir.solver("optimize design.toml -o out");
    run.assert_refused(1, &["level 1", "no equilibrium", "worst element: tetrahedron", "try: "]);
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
