//! Bodies that nothing holds, with an open inlet that a plug closes (`plug = true`) or without: what balances is solved, what
//! does not is refused.

use mesh::Vec3;
use tests::chamber::{self, SIM};
use tests::reported::number;
use tests::workdir::Workdir;
use tests::{block, tag};

use crate::samples::{covered, plugged};

const SCENE: &str = r#"
mesh = "body.msh"
degree = 1

[material]
kind = "neo-hookean"
young = 1e5
poisson = 0.4
density = 1000.0
"#;

/// A cube of 15 mm with a hollow cell in its middle.
fn hollow(more: &str) -> Workdir {
    let inside = |c: f64| (4.9e-3..10.1e-3).contains(&c);
    let body = tag(
        block([3, 3, 3], 5e-3, |c| c == [1, 1, 1], |p| p),
        &[
            ("air", &|c| inside(c.x) && inside(c.y) && inside(c.z)),
            ("top", &|c| c.z > 0.015 - 1e-9),
            ("bottom", &|c| c.z < 1e-9),
            ("sides", &|_| true),
        ],
    );
    let dir = Workdir::with(&body);
    dir.write("sim.toml", &format!("{SCENE}{more}"));
    dir
}

const AIR: &str = "[[chamber]]\non = \"air\"\npressure = 5e3\n";

#[test]
fn a_closed_body_needs_no_support() {
    let dir = hollow(AIR);
    dir.solver("simulate sim.toml -o out").assert_says(&["nothing holds the body"]);
    let report = dir.json("out/report.json");
    let afloat = report["chambers"]["air"]["volume"].as_f64().expect("a volume");
    // the same held in its corner by planes, which take nothing away
    let held = hollow(&format!("{AIR}[contact]\nactivation = 1e-5\n"));
    let volume =
        held.report("simulate sim.toml -o out")["chambers"]["air"]["volume"].as_f64().expect("one");
    assert!((afloat / volume - 1.0).abs() < 1e-9, "{afloat} {volume}");
    let middle = &report["tags"]["air"]["mean_displacement_vector"];
    let off = (0..3).map(|k| middle[k].as_f64().expect("a number").abs()).fold(0.0, f64::max);
    assert!(off < 1e-7, "it stays where it is: {middle}");
}

#[test]
fn loads_that_do_not_balance_are_refused() {
    let pulled = "[[traction]]\non = \"top\"\ntraction = [0, 0, 100]\n";
    for load in ["gravity = [0, 0, -9.81]\n", pulled] {
        let (gravity, table) = if load.starts_with('g') { (load, "") } else { ("", load) };
        let dir = hollow(&format!("{AIR}{table}"));
        let text = dir.text("sim.toml");
        dir.write("sim.toml", &format!("{gravity}{text}"));
        let words = ["nothing holds the body", "do not balance", "[[fixed]]"];
        dir.solver("simulate sim.toml -o out").assert_refused(2, &words);
    }
    let both = format!("{AIR}{pulled}[[traction]]\non = \"bottom\"\ntraction = [0, 0, -100]\n");
    hollow(&both).solver("simulate sim.toml -o out").assert_good();
}

#[test]
fn a_free_body_with_a_plug_goes_nowhere() {
    let dir = plugged();
    let report = dir.report("simulate p1.toml -o out");
    let last = dir.lines("out/steps.jsonl").pop().unwrap();
    // m v of 80 g, were 8 kPa on 4 cm² not balanced for 20 ms: 0.06 kg m/s
    let momentum = [0, 1, 2].map(|k| number(&last["momentum"][k]));
    assert!(momentum.iter().all(|p| p.abs() < 1e-8), "{momentum:?}");
    assert!(number(&report["tags"]["top"]["max_displacement"]) > 1e-4);
    let chamber = &report["chambers"]["cavity"];
    assert!(number(&chamber["volume"]) > 1.02 * number(&chamber["volume_rest"]));
    // without an opening there is nothing to plug
    let hollow = |p: Vec3| (p - Vec3::repeat(0.015)).amax() < 0.006;
    let closed = block([3, 3, 3], 0.01, |c| c == [1, 1, 1], |p| p);
    let body = tag(closed, &[("cavity", &hollow), ("top", &|p| p.z > 0.029)]);
    dir.put("body.msh", &body);
    dir.solver("simulate p1.toml -o no").assert_refused(2, &["on \"cavity\"", "nothing to plug"]);
}

/// Where its rim is fixed, a plug passes its load on to the support alone.
#[test]
fn on_a_fixed_rim_it_changes_nothing() {
    let dir = covered("");
    let scene = format!("{SIM}{}", chamber::PROBES);
    dir.write("open.toml", &scene);
    dir.write("plug.toml", &scene.replace("pressure = 8e3", "pressure = 8e3\nplug = true"));
    let [open, plugged] = ["open", "plug"].map(|scene| {
        dir.solver(&format!("simulate {scene}.toml -o {scene}")).assert_good();
        ["top", "air"].map(|name| dir.probe(scene, name))
    });
    for (open, plugged) in open.into_iter().zip(plugged) {
        assert!((open / plugged - 1.0).abs() < 1e-9, "{open} {plugged}");
    }
}
