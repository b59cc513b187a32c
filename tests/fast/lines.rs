//! Chambers at the end of a line: `supply`, `checked_supply`, a leak, and several on one manifold.

use tests::reported::number;
use tests::workdir::Workdir;

use crate::samples::{HOLLOW, RESISTANCE, supplied as on, twins};

/// Pressure of a chamber at the end of each time step [Pa].
fn pressures(dir: &Workdir, chamber: &str) -> Vec<f64> {
    let report = dir.report("simulate p1.toml -o out");
    let steps = report["steps"].as_array().unwrap().iter();
    steps.map(|step| number(&step["chambers"][chamber]["pressure"])).collect()
}

#[test]
fn hollows_on_a_manifold_share_their_gas() {
    let shared = on("name = \"both\"\non = [\"left\", \"right\"]", "supply = 20e3", 0.0);
    let together = twins(200e3, &shared);
    let found = pressures(&together, "both");
    let volume = &together.json("out/report.json")["chambers"]["both"]["volume_rest"];
    assert!((volume.as_f64().unwrap() / (2.0 * HOLLOW) - 1.0).abs() < 1e-9, "{volume}");
    // each through a line of twice the resistance is the same: the block is symmetric
    let each = shared.replace(&format!("{RESISTANCE:e}"), &format!("{:e}", 2.0 * RESISTANCE));
    let each = ["left", "right"].map(|tag| {
        each.replace("name = \"both\"\non = [\"left\", \"right\"]", &format!("on = \"{tag}\""))
    });
    let apart = pressures(&twins(200e3, &each.concat()), "left");
    for (found, apart) in found.iter().zip(&apart) {
        assert!((found / apart - 1.0).abs() < 1e-3, "{found} {apart}");
    }
}

/// In a static scene the flow has settled.
#[test]
fn without_time_the_flow_has_settled() {
    let dir = twins(200e3, &on("on = \"left\"", "supply = 20e3", 1.0 / RESISTANCE));
    let scene = dir.text("p1.toml");
    dir.write("p1.toml", scene.split("[time]").next().unwrap());
    let pressure = &dir.report("simulate p1.toml -o out")["chambers"]["left"]["pressure"];
    assert!((pressure.as_f64().unwrap() - 10e3).abs() < 1e-6, "{pressure}");
}
