//! A bar that is shaken by its chamber: the pressure of each of 20 time steps is
//! designed.

use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

/// The top should be at one height in the middle of the run and at another at its end.
const DESIGN: &str = r#"
scene = "moving.toml"

[optimizer]
iterations = 30
first_step = 1.0

[[chamber]]
on = "cavity"
slope = [-2e5, 2e5]
change = 8e4

[[objective]]
kind = "displacement"
name = "middle"
weight = 1e9
on = "top"
displacement = [0.0, 0.0, 4e-4]
components = "z"
over = { steps = [9, 10, 11] }

[[objective]]
kind = "displacement"
name = "end"
weight = 1e9
on = "top"
displacement = [0.0, 0.0, 1e-4]
components = "z"
over = { steps = [18, 19, 20] }
"#;

/// The chamber with linear elements, in 20 steps.
pub fn workdir() -> Workdir {
    let dir = chamber::workdir();
    let time = "[time]\nend = 0.2\nsteps = 20\n\n[material]\ndensity = 1000.0";
    let scene = chamber::SIM.replace("degree = 2", "degree = 1").replace("[material]", time);
    dir.write("moving.toml", &scene.replace("pressure = 8e3", "pressure = \"1e4*t\""));
    dir.write("design.toml", DESIGN);
    dir
}

/// Weight of both objectives [1/m⁴], and the heights that they want [m].
const WEIGHT: f64 = 1e9;
const HEIGHTS: [f64; 2] = [4e-4, 1e-4];

/// Rest area A of the top [m²], and by how much it bulges: the variance of u_z over the top
/// divided by the square of its mean, as pressure makes it.
fn bulge(dir: &Workdir) -> (f64, f64) {
    let nowhere = DESIGN.replace(" 4e-4]", " 0.0]").replace(" 1e-4]", " 0.0]");
    dir.write("nowhere.toml", &nowhere);
    dir.solver("gradient nowhere.toml -o nowhere").assert_good();
    // the mean of W ∫ u_z² dA over the last three steps
    let squares = dir.json("nowhere/gradient.json")["terms"]["end"].as_f64().unwrap();
    dir.solver("simulate moving.toml -o start").assert_good();
    let report = dir.json("start/report.json");
    let area = report["tags"]["top"]["area"].as_f64().unwrap();
    let steps = report["steps"].as_array().unwrap().iter().rev().take(3);
    let means = steps.map(|s| s["mean_displacement"]["top"][2].as_f64().unwrap().powi(2));
    let mean = means.sum::<f64>() / 3.0;
    (area, squares / (WEIGHT * area * mean) - 1.0)
}

/// One pressure per step scales the shape of the bulge: with its mean s and variance c s²,
/// J = W A ((s − w)² + c s²) for a wanted height w is least at s = w / (1 + c), and is then
/// W A w² c / (1 + c), as far as the top moves in proportion to the pressure.
#[test]
fn a_pressure_over_time_is_found_within_its_bounds() {
    let dir = workdir();
    // in this slow motion inertia hardly changes the terms: the remainders are within rounding
    let unmeasured = ["density of body", "velocity of body"];
    dir.solver("check design.toml --steps 5").assert_all_but(&unmeasured);
    dir.solver("-q optimize design.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let of = |key: &str| report[key].as_f64().unwrap();
    let (area, c) = bulge(&dir);
    let rest = WEIGHT * area * HEIGHTS.map(|w| w * w).iter().sum::<f64>();
    let above = of("objective_after") / (rest * c / (1.0 + c)) - 1.0;
    eprintln!("c = {c:.4}: {:.4e} is {above:.4} above the least", of("objective_after"));
    // 0.0283 was found: at 4e-4 m the top does not quite move in proportion to the pressure
    assert!((0.0..0.04).contains(&above), "{above}\n{}", dir.text("out/history.jsonl"));

    let pressures: toml::Table = toml::from_str(&dir.text("out/pressures.toml")).unwrap();
    let curve = &pressures["chamber"][0]["pressure"];
    let numbers = |key: &str| -> Vec<f64> {
        curve[key].as_array().unwrap().iter().map(|v| v.as_float().unwrap()).collect()
    };
    let (t, p) = (numbers("t"), numbers("value"));
    assert_eq!(
        (t.len(), p.len(), pressures["chamber"][0]["on"].as_str()),
        (21, 21, Some("cavity"))
    );
    for n in 1..t.len() {
        let slope = (p[n] - p[n - 1]) / (t[n] - t[n - 1]);
        assert!(slope.abs() < 2e5 * (1.0 + 1e-9), "step {n}: {slope}");
    }

    // the table, put into the scene, gives what was promised
    let scene = dir.text("moving.toml");
    let without = &scene[..scene.find("[[chamber]]").unwrap()];
    dir.write("moving.toml", &format!("{without}{}", dir.text("out/pressures.toml")));
    let again = DESIGN.replace("slope = [-2e5, 2e5]", "slope = [-2.1e5, 2.1e5]");
    dir.write("design.toml", &again);
    dir.solver("gradient design.toml -o gradient").assert_good();
    let found = dir.json("gradient/gradient.json")["objective"].as_f64().unwrap();
    assert!((found / of("objective_after") - 1.0).abs() < 1e-6, "{found}");
    dir.solver("simulate moving.toml -o designed").assert_good();
    let top = &dir.json("designed/report.json")["tags"]["top"]["mean_displacement_vector"];
    let mean = top[2].as_f64().unwrap();
    assert!((mean / (HEIGHTS[1] / (1.0 + c)) - 1.0).abs() < 0.02, "{mean}");
}

/// Killed after every checkpoint: the run through time is done again from θ.
#[test]
#[ignore = "fifteen seconds: runs in make test-all; resume.rs kills designs, resume_in_time.rs runs through time"]
fn a_design_in_time_that_is_killed_ends_the_same() {
    let design = |dir: &Workdir| {
        let text = dir.text("design.toml").replace("iterations = 30", "iterations = 3");
        dir.write("design.toml", &text);
    };
    let results = |dir: &Workdir| -> (String, Vec<Value>) {
        let history = dir.text("out/history.jsonl");
        let line = |line: &str| {
            let mut line: Value = serde_json::from_str(line).unwrap();
            for time in ["forward_s", "gradient_s", "time_s"] {
                line.as_object_mut().unwrap().remove(time);
            }
            line
        };
        (dir.text("out/pressures.toml"), history.lines().map(line).collect())
    };
    let command = "--threads 2 -q optimize design.toml -o out";
    let undisturbed = workdir();
    design(&undisturbed);
    undisturbed.solver(command).assert_good();
    let dir = workdir();
    design(&dir);
    let path = dir.path("out/checkpoint.json");
    let mut kills = 0;
    loop {
        let before = std::fs::read(&path).ok();
        let mut child = dir.command(command).spawn().unwrap();
        let finished = loop {
            if let Some(status) = child.try_wait().unwrap() {
                assert!(status.success(), "{status}");
                break true;
            }
            if std::fs::read(&path).ok() != before {
                child.kill().unwrap();
                break child.wait().unwrap().success();
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        };
        if finished {
            break;
        }
        kills += 1;
        assert!(kills < 20, "no progress");
    }
    assert!(kills >= 3, "{kills}");
    assert_eq!(results(&dir), results(&undisturbed));
}
