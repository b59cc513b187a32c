//! Numbers of scenes from measurements: made-up truths, and bad input.

use std::fmt::Write as _;

use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

use crate::samples::{SHEET, TIGHT, TWO, covered, creeping, volumes};

const GRAVITY: &str = "gravity = [0, 0, -9.81]";

const TIME: &str = r#"
[time]
end = 1
steps = 4
method = "quasistatic"

[solver]
relative_tolerance = 1e-13
absolute_tolerance = 1e-12
"#;

/// The scene under a name, with its stresses times a factor, and with its pressure.
fn scene(dir: &Workdir, name: &str, factor: f64, pressure: &str) {
    let (mesh, rest) = chamber::SIM.split_once("degree = 2").unwrap();
    let mut rest = rest.replace("pressure = 8e3", &format!("pressure = \"{pressure}\""));
    for (old, number) in [("c1 = 55e3", 55e3), ("c2 = 5e3", 5e3), ("c3 = 1.7e3", 1.7e3)] {
        rest = rest.replace(old, &format!("{} = {:e}", &old[..2], factor * number));
    }
    rest = rest.replace("d1 = 1e6", &format!("d1 = {:e}\ndensity = 1070", factor * 1e6));
    dir.write(name, &format!("{mesh}degree = 1\n{GRAVITY}\n{rest}\n{}\n{TIME}", chamber::PROBES));
}

/// What the probes of a scene give, as measured tables.
fn measure(dir: &Workdir, scene: &str) {
    let report = dir.report(&format!("simulate {scene} -o truth"));
    let (mut top, mut air) = ("t [s], height [mm]\n".to_owned(), "volume [ml], side\n".to_owned());
    for step in report["steps"].as_array().unwrap() {
        let probe = |name: &str| step["probes"][name].as_f64().unwrap();
        writeln!(top, "{}, {:e}", step["t"], 1e3 * probe("top")).unwrap();
        writeln!(air, "{:e}, left", 1e6 * probe("air")).unwrap();
    }
    let last = air.lines().last().unwrap().to_owned();
    dir.write("top.csv", &top);
    dir.write("air.csv", &format!("volume [ml], side\n1e3, right\n{last}\n"));
}

const EXPERIMENTS: &str = r#"
[[experiment]]
name = "camera"
scene = "sim.toml"
probe = "top"
measured = "top.csv"
time = "t [s]"
columns = ["height [mm]"]
uncertainty = 0.02

[[experiment]]
name = "syringe"
scene = "sim.toml"
probe = "air"
measured = "air.csv"
where = { side = "left" }
columns = ["volume [ml]"]
uncertainty = 0.05
"#;

fn numbers(all: &[&str]) -> String {
    all.iter().map(|keys| format!("[[number]]\n{keys}\n\n")).collect::<String>() + EXPERIMENTS
}

fn workdir() -> Workdir {
    let dir = chamber::workdir();
    scene(&dir, "sim.toml", 1.0, "8e3*t");
    dir
}

/// The same, measured, with a calibration of its modulus.
pub fn measured() -> Workdir {
    let dir = workdir();
    measure(&dir, "sim.toml");
    dir.write("calibrate.toml", &numbers(&["of = \"modulus\""]));
    dir
}

fn value(report: &Value, k: usize) -> f64 {
    report["numbers"][k]["value"].as_f64().unwrap()
}

#[test]
fn a_made_up_truth_is_found_again() {
    let dir = workdir();
    scene(&dir, "real.toml", 1.25, "8e3*t + 300");
    measure(&dir, "real.toml");
    let sought = ["of = \"modulus\"", "of = \"pressure\"\non = \"cavity\""];
    dir.write("calibrate.toml", &numbers(&sought));
    let said = dir.solver("calibrate calibrate.toml -o out");
    said.assert_good();
    let report = dir.json("out/calibration.json");
    assert!((value(&report, 0) / 1.25 - 1.0).abs() < 1e-6, "{report}");
    assert!((value(&report, 1) / 300.0 - 1.0).abs() < 1e-6, "{report}");
    assert!(report["chi2"].as_f64().unwrap() < 1e-8);
    let shares = report["numbers"][0]["shares"].as_object().unwrap();
    assert!((shares.values().map(|s| s.as_f64().unwrap()).sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(said.stdout.contains("measurements: 5, numbers: 2"), "{}", said.stdout);
    assert!(dir.path("out/residuals.svg").exists());
    let material: toml::Table = dir.text("out/material.toml").parse().unwrap();
    let c1 = material["material"]["c1"].as_float().unwrap();
    assert!((c1 / (1.25 * 55e3) - 1.0).abs() < 1e-6);
}

struct Truth {
    folder: fn() -> Workdir,
    /// What is guessed in place of the truth.
    guess: [&'static str; 2],
    times: &'static str,
    /// The keys of a number, what it is found to be, and what `material.toml` then says.
    numbers: &'static [(&'static str, f64)],
    written: (&'static str, &'static str, f64),
}

const TRUTHS: &[Truth] = &[
    Truth {
        folder: || volumes(&TWO.replace("600e3", "750e3")),
        guess: ["750e3", "600e3"],
        times: "",
        numbers: &[("of = \"modulus\"\non = \"floor\"", 1.25)],
        written: ("material", "young", 750e3),
    },
    Truth {
        folder: || volumes(&TWO.replace("600e3", "750e3")),
        guess: ["750e3", "600e3"],
        times: "",
        numbers: &[("of = \"material.floor.young\"", 750e3)],
        written: ("material", "young", 750e3),
    },
    Truth {
        folder: || covered(&(SHEET.replace("1e-4", "1.2e-4") + TIGHT)),
        guess: ["thickness = 1.2e-4", "thickness = 1e-4"],
        times: "",
        numbers: &[("of = \"membrane\"\non = \"top\"", 1.2)],
        written: ("membrane", "thickness", 1.2e-4),
    },
    Truth {
        folder: || creeping(8),
        guess: ["overstress = 0.4\ntime = 2", "overstress = 0.25\ntime = 1"],
        times: "time = \"t [s]\"\n",
        numbers: &[("of = \"relaxation.1.overstress\"", 0.4), ("of = \"relaxation.1.time\"", 2.0)],
        written: ("relaxation", "time", 2.0),
    },
];

/// Of each feature from the rise of the top, and they are written as tables of a scene.
#[test]
fn numbers_of_features_are_found_again() {
    for truth in TRUTHS {
        let dir = (truth.folder)();
        let report = dir.report("simulate p1.toml -o truth");
        let mut table = "t [s], top [mm]\n".to_owned();
        match report["steps"].as_array().filter(|_| !truth.times.is_empty()) {
            Some(steps) => steps.iter().for_each(|step| {
                let top = step["probes"]["top"].as_f64().unwrap();
                writeln!(table, "{}, {:e}", step["t"], 1e3 * top).unwrap();
            }),
            None => writeln!(table, "1, {:e}", 1e3 * dir.probe("truth", "top")).unwrap(),
        }
        dir.write("top.csv", &table);
        let [is, guessed] = truth.guess;
        let scene = dir.text("p1.toml");
        assert!(scene.contains(is), "{is}");
        dir.write("p1.toml", &scene.replace(is, guessed));
        let sought = truth.numbers.iter().map(|(keys, _)| format!("[[number]]\n{keys}\n\n"));
        let experiment = "[[experiment]]\nname = \"camera\"\nscene = \"p1.toml\"\nprobe = \"top\"\n\
                          measured = \"top.csv\"\ncolumns = [\"top [mm]\"]\nuncertainty = 1e-4\n";
        let sought: String = sought.collect();
        dir.write("calibrate.toml", &format!("{sought}{experiment}{}", truth.times));
        dir.solver("calibrate calibrate.toml -o out").assert_good();
        let found = dir.json("out/calibration.json");
        for (k, (keys, expected)) in truth.numbers.iter().enumerate() {
            assert!((value(&found, k) / expected - 1.0).abs() < 1e-6, "{keys}: {found}");
        }
        let written: toml::Table = dir.text("out/material.toml").parse().unwrap();
        let (kind, key, expected) = truth.written;
        let number = written[kind][0][key].as_float().unwrap();
        assert!((number / expected - 1.0).abs() < 1e-6, "{key}: {written}");
    }
}

#[test]
fn measurements_between_time_steps_are_refused() {
    let dir = measured();
    dir.write("top.csv", "t [s], height [mm]\n0.3, 1\n");
    dir.solver("calibrate calibrate.toml -o out")
        .assert_refused(2, &["t = 0.3 s", "0.25, 0.5, 0.75, 1 s"]);
}

/// Two measurements at one state do not tell three numbers apart.
#[test]
fn too_few_measurements_name_what_they_leave_open() {
    let dir = measured();
    let text = numbers(&["of = \"modulus\"", "of = \"pressure\"", "of = \"density\""]);
    dir.write("calibrate.toml", &text.replace("time = \"t [s]\"\n", ""));
    let top = dir.text("top.csv");
    let lines: Vec<&str> = top.lines().collect();
    dir.write("top.csv", &format!("{}\n{}\n", lines[0], lines[4]));
    dir.solver("calibrate calibrate.toml -o out")
        .assert_refused(1, &["2 measurements do not determine", "modulus and pressure"]);
}
