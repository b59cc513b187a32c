//! A bar that is shaken by its chamber: the pressure of each of 10 time steps is
//! designed.

use tests::chamber;
use tests::workdir::Workdir;

/// The top should be at one height in the middle of the run and at another at its end.
const DESIGN: &str = r#"
scene = "moving.toml"

[optimizer]
iterations = 15
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
displacement = [0.0, 0.0, 3e-4]
components = "z"
over = { steps = [5, 6] }

[[objective]]
kind = "displacement"
name = "end"
weight = 1e9
on = "top"
displacement = [0.0, 0.0, 1e-4]
components = "z"
over = { steps = [9, 10] }
"#;

/// The steps of both objectives.
const STEPS: [[usize; 2]; 2] = [[5, 6], [9, 10]];

/// The chamber with linear elements, in 10 steps.
pub fn workdir() -> Workdir {
    let dir = chamber::workdir();
    let time = "[time]\nend = 0.2\nsteps = 10\n\n[material]\ndensity = 1000.0";
    let scene = chamber::SIM.replace("degree = 2", "degree = 1").replace("[material]", time);
    dir.write("moving.toml", &scene.replace("pressure = 8e3", "pressure = \"1e4*t\""));
    dir.write("design.toml", DESIGN);
    dir
}

/// Weight of both objectives [1/m⁴], and the heights that they want [m].
const WEIGHT: f64 = 1e9;
const HEIGHTS: [(&str, f64); 2] = [("middle", 3e-4), ("end", 1e-4)];

/// How the top stands in a run of `moving.toml`, at the steps of each objective: its mean height
/// s [m], and by how much it bulges, the variance of u_z over the top divided by s².
fn bulges(dir: &Workdir, area: f64) -> [[f64; 2]; 2] {
    dir.solver("simulate moving.toml -o run").assert_good();
    let report = dir.json("run/report.json");
    let nowhere = dir.text("design.toml").replace(" 3e-4]", " 0.0]").replace(" 1e-4]", " 0.0]");
    dir.write("nowhere.toml", &nowhere);
    dir.solver("gradient nowhere.toml -o nowhere").assert_good();
    let terms = dir.json("nowhere/gradient.json")["terms"].clone();
    [0, 1].map(|k| {
        // the mean of W ∫ u_z² dA over two steps
        let squares = terms[HEIGHTS[k].0].as_f64().unwrap() / (WEIGHT * area);
        let of_step =
            |n: usize| report["steps"][n - 1]["mean_displacement"]["top"][2].as_f64().unwrap();
        let heights = STEPS[k].map(of_step);
        let [mean, mean_square] =
            [1, 2].map(|n| heights.map(|s| s.powi(n)).iter().sum::<f64>() / 2.0);
        [mean, squares / mean_square - 1.0]
    })
}

/// The pressures of `out/pressures.toml`, with their times; none changes faster than `bound` [Pa/s].
fn pressures(dir: &Workdir, bound: f64) -> (Vec<f64>, Vec<f64>) {
    let pressures: toml::Table = toml::from_str(&dir.text("out/pressures.toml")).unwrap();
    assert_eq!(pressures["chamber"][0]["on"].as_str(), Some("cavity"));
    let curve = &pressures["chamber"][0]["pressure"];
    let numbers = |key: &str| -> Vec<f64> {
        curve[key].as_array().unwrap().iter().map(|v| v.as_float().unwrap()).collect()
    };
    let (t, p) = (numbers("t"), numbers("value"));
    assert_eq!((t.len(), p.len()), (11, 11));
    for n in 1..t.len() {
        let slope = (p[n] - p[n - 1]) / (t[n] - t[n - 1]);
        assert!(slope.abs() < bound * (1.0 + 1e-9), "step {n}: {slope}");
    }
    (t, p)
}

/// With the mean s of the top and the variance c s², J = W A ((s − w)² + c s²) for a wanted height
/// w is least at s = w / (1 + c), and is then W A w² c / (1 + c), if c does not depend on s: with one
/// pressure per step, which scales the shape of the bulge. That c changes with s by the part
/// e = s c′/c moves the least s by the part e c / (2 (1 + c)), and the least J by e² c / (4 (1 + c))
/// of itself: from the lower to the higher s, c falls by a hundredth, so that s is off by a thousandth.
#[test]
fn a_pressure_over_time_is_found() {
    let dir = workdir();
    dir.solver("-q optimize design.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let promised = report["objective_after"].as_f64().unwrap();
    pressures(&dir, 2e5);

    // the table, put into the scene, gives what was promised
    let scene = dir.text("moving.toml");
    let without = &scene[..scene.find("[[chamber]]").unwrap()];
    dir.write("moving.toml", &format!("{without}{}", dir.text("out/pressures.toml")));
    let again = DESIGN.replace("slope = [-2e5, 2e5]", "slope = [-2.1e5, 2.1e5]");
    dir.write("design.toml", &again);
    dir.solver("gradient design.toml -o gradient").assert_good();
    let found = dir.json("gradient/gradient.json")["objective"].as_f64().unwrap();
    assert!((found / promised - 1.0).abs() < 1e-6, "{found}");

    let area = 20e-4;
    let bulges = bulges(&dir, area);
    let least = |k: usize| {
        let ((_, w), [_, c]) = (HEIGHTS[k], bulges[k]);
        WEIGHT * area * w * w * c / (1.0 + c)
    };
    let above = found / (least(0) + least(1)) - 1.0;
    eprintln!("{bulges:?}: {found:.4e} is {above:.2e} above the least");
    assert!(above.abs() < 1e-3, "{above}\n{}", dir.text("out/history.jsonl"));
    for ((name, w), [s, c]) in HEIGHTS.iter().zip(bulges) {
        assert!((s * (1.0 + c) / w - 1.0).abs() < 0.01, "{name}: {s}");
    }
}
