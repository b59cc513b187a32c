//! Chambers at the end of a line: `supply`, `checked_supply`, a leak, and several on one manifold.

use tests::reported::number;
use tests::workdir::Workdir;

use crate::samples::{HOLLOW, RESISTANCE, supplied as on, twins};

/// Pressure of a chamber at the end of each time step [Pa].
fn pressures(dir: &Workdir, chamber: &str) -> Vec<f64> {
    dir.solver("simulate p1.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let steps = report["steps"].as_array().unwrap().iter();
    steps.map(|step| number(&step["chambers"][chamber]["pressure"])).collect()
}

/// In a rigid hollow (P_∞ − P) falls by the formula of implicit Euler, with P_∞ = P_s/(1 + L R) and the time
/// V/(p_a (1/R + L)).
#[test]
fn a_rigid_chamber_fills_exponentially() {
    let leak = 0.25 / RESISTANCE;
    let dir = twins(1e12, &on("on = \"left\"", "supply = 20e3", leak));
    let (settled, rate) = (20e3 / 1.25, 1.25 / 0.1 * 0.05);
    for (n, found) in pressures(&dir, "left").into_iter().enumerate() {
        let expected = settled * (1.0 - f64::powi(1.0 + rate, -(n as i32 + 1)));
        assert!((found / expected - 1.0).abs() < 1e-4, "step {n}: {found} {expected}");
    }
}

/// While the pump is off again, a check valve keeps the air that the other line lets go.
#[test]
fn a_check_valve_keeps_the_air() {
    let pump = "supply = { t = [0, 0.25, 0.26, 0.5], value = [20e3, 20e3, 0, 0] }";
    let both =
        on("on = \"left\"", pump, 0.0) + &on("on = \"right\"", &format!("checked_{pump}"), 0.0);
    let dir = twins(200e3, &both);
    let (open, checked) = (pressures(&dir, "left"), pressures(&dir, "right"));
    let largest = checked[4];
    assert!(largest > 15e3 && (open[4] / largest - 1.0).abs() < 1e-2, "{open:?} {checked:?}");
    assert!(open[9] < 0.3 * largest, "{open:?}");
    // that of the other changes its volume a little
    assert!((checked[9] / largest - 1.0).abs() < 1e-2, "{checked:?}");
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
    dir.solver("simulate p1.toml -o out").assert_good();
    let pressure = &dir.json("out/report.json")["chambers"]["left"]["pressure"];
    assert!((pressure.as_f64().unwrap() - 10e3).abs() < 1e-6, "{pressure}");
}
