//! `plug = true` in `[[chamber]]`: bodies with an open inlet that nothing holds.

use mesh::Vec3;
use mesh::io::write_tets;
use serde_json::Value;
use tests::chamber::{self, SIM};
use tests::reported::number;
use tests::{block, tag};

use crate::samples::{covered, plugged};

#[test]
fn a_free_body_with_a_plug_goes_nowhere() {
    let dir = plugged();
    dir.solver("simulate p1.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let steps = dir.text("out/steps.jsonl");
    let last: Value = serde_json::from_str(steps.lines().last().unwrap()).unwrap();
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
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
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
