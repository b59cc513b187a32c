//! Rigid parts of scenes, by the program: a plate that is glued to the top of a block.

use tests::chamber;
use tests::workdir::Workdir;

/// The plate, with more keys.
fn with_plate(keys: &str) -> Workdir {
    let dir = chamber::workdir();
    let text = dir.text("sim.toml");
    dir.write("plate.toml", &format!("{text}\n[[rigid]]\non = \"top\"\n{keys}"));
    dir
}

#[track_caller]
fn refused(keys: &str, words: &[&str]) {
    let dir = with_plate(keys);
    let run = dir.solver("simulate plate.toml -o out");
    run.assert_refused(2, words);
    assert!(!dir.path("out/report.json").exists());
}

/// The seat bears what hangs on the plate, which turns and keeps its lengths.
#[test]
fn a_plate_that_is_glued_on_bears_its_load() {
    let dir = with_plate("mass = 0.02\nforce = [0.1, 0, \"-0.3*t\"]\n");
    let text = dir.text("plate.toml");
    dir.write(
        "plate.toml",
        &format!("gravity = [0, 0, -9.81]\n{text}")
            .replace("d1 = 1e6", "d1 = 1e6\ndensity = 0.001"),
    );
    dir.solver("simulate plate.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let last = report["steps"].as_array().unwrap().last().unwrap();
    let held = |k: usize| last["reactions"]["seat"][k].as_f64().unwrap();
    let gas = -chamber::PRESSURE * chamber::MOUTH * chamber::MOUTH;
    assert!((held(0) - gas + 0.1).abs() < 1e-6, "{}", held(0));
    assert!((held(2) - 0.3 - 0.02 * 9.81).abs() < 1e-5, "{}", held(2));
    let plate = &last["rigid"]["top"];
    let turn = plate["rotation"][1].as_f64().unwrap();
    assert!(turn > 0.01, "{turn}");
    // numbers that can be varied and have derivatives
    let list = dir.solver("list --numbers plate.toml");
    list.assert_good();
    for path in ["rigid.top.mass", "rigid.top.force.x", "rigid.top.force.z"] {
        assert!(list.stdout.contains(path), "{path}");
    }
}

#[test]
fn derivatives_by_mass_and_force_are_those_of_the_runs() {
    let dir = with_plate("mass = 0.02\nforce = [0.1, 0, -0.3]\n");
    let text = dir.text("plate.toml");
    dir.write(
        "plate.toml",
        &format!("degree = 1\ngravity = [0, 0, -9.81]\n{text}")
            .replace("degree = 2\n", "")
            .replace("d1 = 1e6", "d1 = 1e6\ndensity = 1000"),
    );
    let design = "scene = \"plate.toml\"\n[shape]\non = \"cavity\"\n[[shape.level]]\nhandles = 2\niterations = 1\n\
                  [[objective]]\nkind = \"displacement\"\nname = \"up\"\non = \"top\"\naxis = [0, 0, 1]\n\
                  target = 2e-3\nweight = 1e6\n";
    dir.write("plate.design.toml", design);
    dir.solver("check plate.design.toml --steps 6").assert_good();
}

#[test]
fn parts_that_cannot_be_are_refused() {
    refused("along = \"z\"\n", &["along", "turns = false"]);
    refused("along = \"\"\n", &["along", "[[fixed]]"]);
    refused("mass = 1\n", &["mass", "gravity"]);
    refused("mass = -1\n", &["mass", "0 or more"]);
    refused("along = \"z\"\nturns = false\nforce = [1, 0, 0]\n", &["force", "along x"]);
    refused("[[rigid]]\non = \"top\"\n", &["given twice"]);
    refused("[[rigid]]\non = \"seat\"\n", &["seat", "[[fixed]]"]);
    refused("[[rigid]]\non = \"nowhere\"\n", &["nowhere", "top"]);
}

/// A design may not move what is rigid.
#[test]
fn a_design_of_a_rigid_tag_is_refused() {
    let dir = with_plate("");
    let design = dir.text("design.toml").replace("sim.toml", "plate.toml").replacen(
        "on = \"cavity\"",
        "on = [\"cavity\", \"top\"]",
        1,
    );
    dir.write("plate.design.toml", &design);
    dir.solver("optimize plate.design.toml -o out")
        .assert_refused(2, &["[shape]", "[[rigid]]", "top"]);
}
