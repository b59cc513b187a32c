//! `[[relaxation]]`: creep of a bar that is pulled.

use tests::workdir::Workdir;

use crate::samples::cube;

/// Young's modulus [Pa] and Poisson's ratio.
const LAW: (f64, f64) = (264e3, 0.49);
/// Overstress [1] and time [s].
pub const BRANCH: (f64, f64) = (0.4, 2.0);
/// Small, so that strain is: 0.1 %.
const PULL: f64 = 264.0;

/// The cube, whose top is pulled from the first time step on.
pub fn bar(relaxation: &str, steps: usize) -> Workdir {
    let (young, poisson) = LAW;
    let law = format!(
        "[material]\nkind = \"neo-hookean\"\nyoung = {young:e}\npoisson = {poisson}\n{relaxation}"
    );
    let loads = format!(
        "[[traction]]\non = \"top\"\ntraction = [0, 0, {PULL}]\n\
         [[probe]]\nname = \"top\"\nkind = \"displacement\"\non = \"top\"\naxis = [0, 0, 1]\n\
         [time]\nend = 4\nsteps = {steps}\nmethod = \"quasistatic\"\n"
    );
    cube(&law, &loads)
}

pub fn table((overstress, time): (f64, f64)) -> String {
    format!("[[relaxation]]\noverstress = {overstress}\ntime = {time}\n")
}

/// Rise of the top at the end of each time step [m].
pub fn tops(dir: &Workdir, folder: &str) -> Vec<f64> {
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
    let dir = bar(&table(BRANCH), 20);
    dir.solver("simulate p1.toml -o out").assert_good();
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
