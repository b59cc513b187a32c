//! `[[mullins]]`: stress and inflations of softened bodies.

use std::fmt::Write as _;

use mesh::io::write_tets;
use serde_json::Value;
use tests::meshes::shell_octant;
use tests::radial::mooney_rivlin;
use tests::reported::number;
use tests::tag;
use tests::workdir::Workdir;

use crate::samples::cube;

/// c₁ and c₂ [Pa], and the bulk modulus [Pa].
const LAW: [f64; 3] = [40e3, 6e3, 5e6];
/// r, m [Pa] and β.
pub const SOFTENING: [f64; 3] = [1.8, 400.0, 0.15];

pub fn table([r, m, beta]: [f64; 3]) -> String {
    format!("[[mullins]]\nr = {r}\nm = {m}\nbeta = {beta}\n")
}

fn material(bulk: f64) -> String {
    let [c1, c2, _] = LAW;
    format!(
        "[material]\nkind = \"mooney-rivlin\"\nc1 = {c1}\nc2 = {c2}\nc3 = 0\nd1 = {}\n",
        0.5 * bulk
    )
}

/// The cube, whose top rises so far [m] in steps of a second.
pub fn moved(softening: &str, rises: &[f64]) -> Workdir {
    let (count, times) = (rises.len(), Vec::from_iter(0..=rises.len()));
    let values: Vec<f64> = [0.0].iter().chain(rises).copied().collect();
    let loads = format!(
        "[[fixed]]\non = \"top\"\ncomponents = \"z\"\n\
         displacement = [0, 0, {{ t = {times:?}, value = {values:?} }}]\n\
         [[probe]]\nname = \"pull\"\nkind = \"reaction\"\non = \"top\"\naxis = [0, 0, 1]\n\
         [time]\nend = {count}\nsteps = {count}\nmethod = \"quasistatic\"\n"
    );
    cube(&(material(LAW[2]) + softening), &loads)
}

/// erf by Simpson's rule.
fn erf(x: f64) -> f64 {
    let weight = |i: i32| if i == 0 || i == 400 { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    let part = |i: i32| weight(i) * (-(x * f64::from(i) / 400.0).powi(2)).exp();
    2.0 / std::f64::consts::PI.sqrt() * x / 1200.0 * (0..=400).map(part).sum::<f64>()
}

fn factor(w: f64, largest: f64) -> f64 {
    let [r, m, beta] = SOFTENING;
    if w < largest { 1.0 - erf((largest - w) / (m + beta * largest)) / r } else { 1.0 }
}

/// W of principal stretches without their change of volume [J/m³].
fn energy_density(l: [f64; 3]) -> f64 {
    let ratio = l.iter().product::<f64>().powf(-1.0 / 3.0);
    let s = l.map(|l| (l * ratio).powi(2));
    let second = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
    LAW[0] * (s.iter().sum::<f64>() - 3.0) + LAW[1] * (second - 3.0)
}

/// Nominal stress and W of a softened bar at a stretch; the lateral one is found by halving [Pa, J/m³].
fn pulled(stretch: f64, largest: f64) -> (f64, f64) {
    let [c1, c2, bulk] = LAW;
    let of = |a: f64| {
        let l = [a, a, stretch];
        let (w, isochoric) = (energy_density(l), mooney_rivlin(c1, c2, 0.0)(l));
        let pressure = bulk * l.iter().product::<f64>().ln();
        let stress = |i: usize| factor(w, largest) * isochoric[i] + pressure / l[i];
        (stress(0), stress(2), w)
    };
    let (mut low, mut high) = (0.5, 1.1);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if of(middle).0 > 0.0 { high = middle } else { low = middle }
    }
    let (_, along, w) = of(low);
    (along, w)
}

fn probes(report: &Value, name: &str) -> Vec<f64> {
    let steps = report["steps"].as_array().unwrap().iter();
    steps.map(|step| number(&step["probes"][name])).collect()
}

#[test]
fn a_bar_is_softened_as_the_formula_says() {
    let rises = [8e-3, 5e-3, 1e-3, 4e-3, 7.9e-3, 11e-3, 2e-3, 10e-3];
    let dir = moved(&table(SOFTENING), &rises);
    dir.solver("simulate p1.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let mut largest = 0.0_f64;
    for (rise, pull) in rises.iter().zip(probes(&report, "pull")) {
        let (stress, w) = pulled(1.0 + rise / 0.02, largest);
        assert!((pull.abs() / (stress * 4e-4) - 1.0).abs() < 1e-8, "{rise}: {pull} {stress}");
        largest = largest.max(w);
    }
    let own = &report["mullins"][0];
    let near = |key: &str, expected: f64| {
        assert!((number(&own[key]) / expected - 1.0).abs() < 1e-8, "{key} {expected}: {own}");
    };
    let (_, w) = pulled(1.5, largest);
    near("largest_energy", largest);
    near("factor", factor(w, largest));
    near("factor_at_rest", factor(0.0, largest));
    near("mean_factor_at_rest", factor(0.0, largest));
    near("lost", 8e-6 * simpson(0.0, largest, |w| 1.0 - factor(w, largest)));
    let picture = std::fs::read(dir.path("out/result.vtu")).unwrap();
    assert!(String::from_utf8_lossy(&picture).contains("\"mullins_factor_at_rest"));
}

#[test]
fn a_load_that_never_falls_has_the_bits_of_a_body_without_softening() {
    let rises = [2e-3, 4e-3, 9e-3];
    let states = ["", &table(SOFTENING)].map(|softening| {
        let dir = moved(softening, &rises);
        dir.solver("simulate p1.toml -o out").assert_good();
        std::fs::read(dir.path("out/displacement.npy")).unwrap()
    });
    assert!(states[0] == states[1]);
}

/// An integral by Simpson's rule.
fn simpson(from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
    let n = 400;
    let h = (to - from) / f64::from(n);
    let weight = |i: i32| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    h / 3.0 * (0..=n).map(|i| weight(i) * of(from + h * f64::from(i))).sum::<f64>()
}

/// The pressure at which an incompressible sphere of radii A and B has an inner stretch, by the integral of
/// η W′/(λ³ − 1) through the wall; it was inflated to an inner stretch before [Pa].
fn pressure(stretch: f64, before: f64) -> f64 {
    let beyond = |l: f64| l.powi(3) - 1.0;
    let outer = (1.0 + beyond(stretch) * (A / B).powi(3)).cbrt();
    let w = |l: f64| energy_density([l.powi(-2), l, l]);
    let slope = |l: f64| (w(l + 1e-6) - w(l - 1e-6)) / 2e-6;
    // a shell that has λ now had λ_m, with the same ratio of λ³ − 1 all through the wall
    let ratio = beyond(before) / beyond(stretch);
    let earlier = |l: f64| (1.0 + ratio * beyond(l)).cbrt();
    simpson(outer, stretch, |l| factor(w(l), w(earlier(l))) * slope(l) / beyond(l))
}

/// Inner and outer radius [m].
const A: f64 = 0.01;
const B: f64 = 0.015;

/// An octant of a thick sphere, whose bulk modulus is 1000 shear moduli.
fn sphere(softening: &str, keys: &str, pressure: &str, [end, steps]: [usize; 2]) -> Workdir {
    let dir = Workdir::new();
    let body = tag(
        shell_octant(A, B, 6, 3),
        &[
            ("x", &|p| p.x < 1e-9),
            ("y", &|p| p.y < 1e-9),
            ("z", &|p| p.z < 1e-9),
            ("inside", &|p| p.norm() < 0.5 * (A + B)),
        ],
    );
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    let mut scene = format!("mesh = \"body.msh\"\n{keys}{}{softening}", material(92e6));
    for axis in ["x", "y", "z"] {
        writeln!(scene, "[[symmetry]]\non = \"{axis}\"").unwrap();
    }
    writeln!(
        scene,
        "[[chamber]]\non = \"inside\"\npressure = {pressure}\n\
         [time]\nend = {end}\nsteps = {steps}\nmethod = \"quasistatic\"\n\
         [solver]\ndilatation = \"mean\"\nlocking = \"never\""
    )
    .unwrap();
    dir.write("p1.toml", &scene);
    dir
}

#[test]
fn a_thick_sphere_is_wider_at_the_second_inflation() {
    let (first, second) = (1.3, 1.2);
    let [high, low] = [pressure(first, 1.0), pressure(second, first)];
    // as wide without softening the sphere would need more
    assert!(low < 0.75 * pressure(second, 1.0), "{high} {low}");
    let times = format!("{{ t = [0, 1, 2, 3], value = [0, {high}, 0, {low}] }}");
    let dir = sphere(&table(SOFTENING), "", &times, [3, 3]);
    dir.solver("simulate p1.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let inflations = report["inflations"].as_array().unwrap();
    assert_eq!(inflations.len(), 2, "{inflations:?}");
    let rest = number(&report["chambers"]["inside"]["volume_rest"]);
    let error = |inflation: &Value, stretch: f64| {
        let found = (number(&inflation["peak"]["volume"]) / rest).cbrt();
        (found - 1.0) / (stretch - 1.0) - 1.0
    };
    let errors = [error(&inflations[0], first), error(&inflations[1], second)];
    eprintln!("thick sphere, inner stretch at the first and second inflation: {errors:+.4?}");
    // straight facets
    assert!(errors.iter().all(|error| error.abs() < 0.03), "{errors:?}");
    assert!((errors[1] - errors[0]).abs() < 0.01, "{errors:?}");
}

/// The law has no fatigue beyond the first cycle. At the same largest pressure all inflations are equal; on the
/// way there the first is stiffer, and all others are equal.
#[test]
fn inflations_after_the_first_are_softer_and_equal() {
    let dir = sphere(&table(SOFTENING), "degree = 1\n", "\"15e3*sin(pi*t)^2\"", [10, 80]);
    let said = dir.solver("simulate p1.toml -o out --final-only");
    said.assert_good();
    let report = dir.json("out/report.json");
    let inflations = report["inflations"].as_array().unwrap();
    assert_eq!(inflations.len(), 10, "{inflations:?}");
    assert!(inflations.iter().enumerate().all(|(i, found)| found["number"] == i + 1));
    let rest = number(&report["chambers"]["inside"]["volume_rest"]);
    let by = |n: usize, at: &str| number(&inflations[n][at]["volume"]) - rest;
    for n in 1..10 {
        assert!((by(n, "peak") / by(0, "peak") - 1.0).abs() < 1e-6, "{n}");
        assert!((by(n, "halfway") / by(1, "halfway") - 1.0).abs() < 1e-6, "{n}");
    }
    assert!(by(1, "halfway") > 1.2 * by(0, "halfway"), "{inflations:?}");
    for number in [1, 10] {
        assert!(said.stderr.contains(&format!("inflation {number} of inside: t = ")));
    }
    assert!(!said.stderr.contains("inflation 2 of inside"), "{}", said.stderr);
}

/// A bar of what is known of the effect is none where the scene simulates it.
#[test]
fn a_simulated_effect_has_no_error_bar() {
    let dir = moved(&table(SOFTENING), &[8e-3, 3e-3]);
    let scene = dir.text("p1.toml").replace("c3 = 0\n", "c3 = 0\nmullins = 0.1\ncreep = 0.2\n");
    dir.write("p1.toml", &format!("{scene}[uncertainty]\nnumbers = {{ \"mullins.1.m\" = 40 }}\n"));
    dir.solver("simulate p1.toml -o out").assert_good();
    let report = dir.json("out/report.json");
    let bars = report["error_bars"]["pull"]["bars"].as_array().unwrap();
    let all: Vec<&str> = bars.iter().map(|bar| bar["of"].as_str().unwrap()).collect();
    assert_eq!(all, ["creep", "mullins.1.m"]);
}
