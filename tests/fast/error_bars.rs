//! Error bars of probes: what reports say of them. Their derivatives are those of `numbers.rs`, in a static scene of
//! `materials.rs`.

use tests::chamber;
use tests::workdir::Workdir;

use crate::samples::SOFTENING;

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

/// What the material is known to soften by goes one way, with the derivative by the modulus; creep that
/// is simulated is no error.
#[test]
fn softening_of_the_material_has_bars() {
    let dir = workdir(TIME);
    let sound = dir.text("sim.toml");
    let soft = sound.replacen("d1 = 1e6", "d1 = 1e6\ncreep = 0.25\nmullins = 0.1", 1);
    let bars = |scene: &str| {
        dir.write("sim.toml", scene);
        let report = dir.report("simulate sim.toml -o out --restart");
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
    let relaxes = "[[relaxation]]\noverstress = 0.25\ntime = 0.01\n";
    for (table, simulated, known) in
        [(relaxes, "creep", "mullins"), (SOFTENING, "mullins", "creep")]
    {
        let found = bars(&format!("{soft}\n{table}"));
        assert!(of(&found, simulated).is_none() && of(&found, known).is_some(), "{found:?}");
    }
}

#[test]
fn bars_are_derivatives_times_what_the_numbers_are_off() {
    let dir = workdir("");
    let run = dir.solver("simulate sim.toml -o out");
    run.assert_says(&["error bars, to first order"]);
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
