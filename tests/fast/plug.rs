//! `plug = true` in `[[chamber]]`: bodies with an open inlet that nothing holds.

use mesh::Vec3;
use mesh::io::write_tets;
use serde_json::Value;
use tests::chamber::{self, DESIGN, PROBES, SIM};
use tests::workdir::Workdir;
use tests::{block, tag};

const PLUG: &str = "pressure = 8e3\nplug = true";

/// The block with the open chamber, without any support, for some time.
fn free() -> Workdir {
    let dir = chamber::workdir();
    let held = SIM.find("[[fixed]]").unwrap()..SIM.find("[[chamber]]").unwrap();
    let mut scene =
        SIM.replace("degree = 2", "degree = 1").replace("d1 = 1e6", "d1 = 1e6\ndensity = 1000");
    scene = scene.replace(&SIM[held], "");
    // the derivatives by density are small
    let time = "\n[solver]\nabsolute_tolerance = 1e-10\n[time]\nend = 0.02\nsteps = 4\nmethod = \"implicit-euler\"\n";
    dir.write("open.toml", &format!("{scene}{time}"));
    dir.write("p1.toml", &format!("{}{time}", scene.replace("pressure = 8e3", PLUG)));
    dir
}

#[test]
fn a_free_body_with_a_plug_goes_nowhere() {
    let dir = free();
    let refused = dir.solver("simulate open.toml -o open");
    refused.assert_refused(2, &["[[chamber]] on \"cavity\"", "are free", "plug = true"]);
    dir.solver("simulate p1.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let last = dir
        .text("out/steps.jsonl")
        .lines()
        .last()
        .map(serde_json::from_str::<Value>)
        .unwrap()
        .unwrap();
    // m v of 80 g, were 8 kPa on 4 cm² not balanced for 20 ms: 0.06 kg m/s
    let momentum: Vec<f64> =
        last["momentum"].as_array().unwrap().iter().map(|p| p.as_f64().unwrap()).collect();
    assert!(momentum.iter().all(|p| p.abs() < 1e-8), "{momentum:?}");
    assert!(report["tags"]["top"]["max_displacement"].as_f64().unwrap() > 1e-4);
    let chamber = &report["chambers"]["cavity"];
    assert!(chamber["volume"].as_f64().unwrap() > 1.02 * chamber["volume_rest"].as_f64().unwrap());
}

/// Where its rim is fixed, a plug passes its load on to the support alone.
#[test]
fn on_a_fixed_rim_it_changes_nothing() {
    let dir = chamber::workdir();
    dir.write("sim.toml", &format!("{SIM}{PROBES}"));
    dir.write("plug.toml", &format!("{}{PROBES}", SIM.replace("pressure = 8e3", PLUG)));
    let probes = |scene: &str| {
        dir.solver(&format!("simulate {scene}.toml -o {scene}")).assert_good();
        let probes = dir.json(&format!("{scene}/report.json"))["probes"].clone();
        ["top", "air"].map(|name| probes[name]["value"].as_f64().unwrap())
    };
    for (open, plugged) in probes("sim").into_iter().zip(probes("plug")) {
        assert!((open / plugged - 1.0).abs() < 1e-9, "{open} {plugged}");
    }
}

#[test]
fn gradients_of_a_plugged_body_pass_the_taylor_test() {
    let dir = free();
    let design = DESIGN.split("[[objective]]").next().unwrap();
    let terms = "[[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = -1e5\non = \"cavity\"\nmeasure = \"deformed\"\n
[[objective]]\nkind = \"displacement\"\nname = \"lift\"\nweight = 1e9\non = \"top\"\ndisplacement = [0, 0, 1e-3]\nmeasure = \"deformed\"\n";
    dir.write("design.toml", &format!("{}{terms}", design.replace("sim.toml", "p1.toml")));
    dir.solver("check design.toml --handles 3").assert_good();
}

#[test]
fn plugs_without_an_opening_are_refused() {
    let dir = free();
    dir.write("bad.toml", &dir.text("p1.toml").replace("plug = true", "plug = 1"));
    dir.solver("simulate bad.toml -o out").assert_refused(2, &["plug", "boolean"]);
    let hollow = |p: Vec3| (p - Vec3::repeat(0.015)).amax() < 0.006;
    let closed = block([3, 3, 3], 0.01, |c| c == [1, 1, 1], |p| p);
    let body = tag(closed, &[("cavity", &hollow), ("top", &|p| p.z > 0.029)]);
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    dir.solver("simulate p1.toml -o out").assert_refused(2, &["on \"cavity\"", "nothing to plug"]);
}
