//! `[[relaxation]]`: creep, gradients, resuming, calibration, and what is refused.

use std::fmt::Write as _;
use std::process::Stdio;
use std::time::Duration;

use mesh::io::write_tets;
use tests::workdir::Workdir;
use tests::{block, tag};

/// Young's modulus [Pa] and Poisson's ratio.
const LAW: (f64, f64) = (264e3, 0.49);
/// Overstress [1] and time [s].
const BRANCH: (f64, f64) = (0.4, 2.0);
/// Small, so that strain is: 0.1 %.
const PULL: f64 = 264.0;

/// A bar of 20 x 20 x 20 mm that is pulled from the first time step on, free to contract.
fn bar(relaxation: &str, steps: usize) -> Workdir {
    let dir = Workdir::new();
    let mesh = block([2, 2, 2], 0.01, |_| false, |p| p);
    let body = tag(
        mesh,
        &[
            ("bottom", &|p| p.z < 1e-9),
            ("top", &|p| p.z > 0.02 - 1e-9),
            ("left", &|p| p.x < 1e-9),
            ("front", &|p| p.y < 1e-9),
        ],
    );
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    let (young, poisson) = LAW;
    let scene = format!(
        r#"
mesh = "body.msh"
degree = 1

[material]
kind = "neo-hookean"
young = {young:e}
poisson = {poisson}

{relaxation}
[[fixed]]
on = "bottom"
components = "z"

[[fixed]]
on = "left"
components = "x"

[[fixed]]
on = "front"
components = "y"

[[traction]]
on = "top"
traction = [0, 0, {PULL}]

[[probe]]
name = "top"
kind = "displacement"
on = "top"
axis = [0, 0, 1]

[time]
end = 4
steps = {steps}
method = "quasistatic"

[solver]
relative_tolerance = 1e-13
absolute_tolerance = 1e-12
"#
    );
    dir.write("sim.toml", &scene);
    dir
}

fn relaxation((overstress, time): (f64, f64)) -> String {
    format!("[[relaxation]]\noverstress = {overstress}\ntime = {time}\n")
}

/// Rise of the top at the end of each time step [m].
fn tops(dir: &Workdir, folder: &str) -> Vec<f64> {
    let report = dir.json(&format!("{folder}/report.json"));
    let steps = report["steps"].as_array().unwrap().iter();
    steps.map(|step| step["probes"]["top"].as_f64().unwrap()).collect()
}

/// The standard linear solid under constant stress σ, its shear stiff at once by 1 + γ: strain σ D(t)
/// with D = 1/9K + 1/3μ (1 − γ/(1 + γ) e^(−t/(1 + γ)τ)); with implicit Euler's formula in place of
/// the exponential, whose first step has the branch relax by it, too.
#[test]
fn a_bar_creeps_as_the_standard_linear_solid() {
    let (young, poisson) = LAW;
    let (shear, bulk) = (young / 2.0 / (1.0 + poisson), young / 3.0 / (1.0 - 2.0 * poisson));
    let (gamma, time) = BRANCH;
    let dir = bar(&relaxation(BRANCH), 20);
    let said = dir.solver("simulate sim.toml -o out");
    said.assert_good();
    assert!(
        said.stderr.contains("40.0 % more isochoric stress at once, for 2 s"),
        "{}",
        said.stderr
    );
    let (late, a) = ((1.0 + gamma) * time, 0.2 / time);
    // z: what the branch has relaxed of the strain; ε = (σ/μ + γ z/(1 + a)) / (1 + γ/(1 + a))
    let (mut z, part) = (0.0, gamma / (1.0 + a));
    for (n, top) in tops(&dir, "out").into_iter().enumerate() {
        let strain = top / 0.02;
        let shape = (1.0 + part * z) / (1.0 + part);
        z = (z + a * shape) / (1.0 + a);
        let expected = PULL * (1.0 / (9.0 * bulk) + shape / (3.0 * shear));
        // strain of 0.1 %: the law is not linear to first order in it
        assert!((strain / expected - 1.0).abs() < 3e-3, "step {n}: {strain:e} {expected:e}");
        let exact = 1.0 - gamma / (1.0 + gamma) * (-0.2 * (n + 1) as f64 / late).exp();
        assert!((shape / exact - 1.0).abs() < 0.02, "step {n}: {shape} {exact}");
    }
    // at once 1 + γ times as stiff in shear
    let first = tops(&dir, "out")[0] / 0.02;
    let elastic = PULL * (1.0 / (9.0 * bulk) + 1.0 / (3.0 * shear));
    assert!(first < 0.76 * elastic, "{first:e} {elastic:e}");
}

#[test]
fn a_calibration_finds_overstress_and_time() {
    let dir = bar(&relaxation(BRANCH), 8);
    dir.solver("simulate sim.toml -o truth").assert_good();
    let mut table = "t [s], top [mm]\n".to_owned();
    for (n, top) in tops(&dir, "truth").into_iter().enumerate() {
        writeln!(table, "{}, {:e}", 0.5 * (n + 1) as f64, 1e3 * top).unwrap();
    }
    dir.write("top.csv", &table);
    let guess = bar(&relaxation((0.25, 1.0)), 8);
    dir.write("sim.toml", &guess.text("sim.toml"));
    let config = |numbers: &str| {
        format!(
            "{numbers}\n[[experiment]]\nname = \"creep\"\nscene = \"sim.toml\"\nprobe = \"top\"\n\
             measured = \"top.csv\"\ntime = \"t [s]\"\ncolumns = [\"top [mm]\"]\nuncertainty = 1e-4\n"
        )
    };
    let both = "[[number]]\nof = \"overstress\"\n[[number]]\nof = \"relaxation-time\"\n";
    dir.write("calibrate.toml", &config(both));
    dir.solver("calibrate calibrate.toml -o out").assert_good();
    let found = dir.json("out/calibration.json");
    let value = |k: usize| found["numbers"][k]["value"].as_f64().unwrap();
    assert!((value(0) / BRANCH.0 - 1.0).abs() < 1e-6, "{found}");
    assert!((value(1) / BRANCH.1 - 1.0).abs() < 1e-6, "{found}");
    let material: toml::Table = dir.text("out/material.toml").parse().unwrap();
    let written = material["relaxation"][0]["time"].as_float().unwrap();
    assert!((written / BRANCH.1 - 1.0).abs() < 1e-6, "{material}");
    for (numbers, words) in [
        ("[[number]]\nof = \"overstress\"\nbranch = 2\n", "has 1 tables [[relaxation]]"),
        ("[[number]]\nof = \"overstress\"\nbranch = 0\n", "branch = 0"),
        ("[[number]]\nof = \"modulus\"\nbranch = 1\n", "branch is for overstress"),
    ] {
        dir.write("calibrate.toml", &config(numbers));
        dir.solver("calibrate calibrate.toml -o out").assert_refused(2, &[words]);
    }
}

#[test]
fn gradients_pass_their_test() {
    let dir = bar(&relaxation(BRANCH), 3);
    dir.write(
        "design.toml",
        "scene = \"sim.toml\"\n[shape]\non = \"top\"\n[[shape.level]]\nhandles = 1\niterations = 1\n\
         [[objective]]\nkind = \"probe\"\nname = \"low\"\nprobe = \"top\"\ntarget = 0.0\n\
         over = \"uniform\"\nweight = 1e9\n",
    );
    let said = dir.solver("check design.toml");
    said.assert_good();
    eprintln!("{}", said.stdout);
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn a_killed_run_remembers_its_relaxed_stresses() {
    let command = "--threads 2 -q simulate sim.toml -o out";
    let undisturbed = bar(&relaxation(BRANCH), 400);
    undisturbed.solver(command).assert_good();
    let dir = bar(&relaxation(BRANCH), 400);
    let mut child = dir.command(command).stderr(Stdio::null()).spawn().unwrap();
    while !dir.path("out/checkpoint.json").exists() {
        assert!(child.try_wait().unwrap().is_none(), "over before it was killed");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    assert!(!child.wait().unwrap().success(), "over before it was killed");
    dir.solver(command).assert_good();
    assert!(dir.text("out/steps.jsonl") == undisturbed.text("out/steps.jsonl"));
}

#[test]
fn what_means_nothing_is_refused() {
    let refused = |dir: &Workdir, words: &[&str]| {
        dir.solver("simulate sim.toml -o out").assert_refused(2, words);
    };
    refused(&bar(&relaxation((-0.1, 2.0)), 2), &["overstress = -0.1", "such as 0.1"]);
    refused(&bar(&relaxation((0.1, 0.0)), 2), &["time = 0 s"]);
    let elsewhere = format!("{}on = \"insert\"\n", relaxation(BRANCH));
    refused(&bar(&elsewhere, 2), &["on \"insert\"", "there are: body"]);
    let dir = bar(&relaxation(BRANCH), 2);
    let scene = dir.text("sim.toml");
    let (without, _) = scene.split_once("[time]").unwrap();
    dir.write("sim.toml", without);
    refused(&dir, &["[[relaxation]] without [time]", "quasistatic"]);
    dir.write("sim.toml", &scene.replace("neo-hookean", "saint-venant-kirchhoff"));
    refused(&dir, &["saint-venant-kirchhoff", "neo-hookean, yeoh, gent"]);
}
