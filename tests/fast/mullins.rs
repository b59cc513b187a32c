//! `[[mullins]]`: inflations of softened bodies.

use std::fmt::Write as _;

use tests::meshes::shell_octant;
use tests::reported::number;
use tests::tag;
use tests::workdir::Workdir;

use crate::samples::{SOFTENING, moved, silicone};

#[test]
fn a_load_that_never_falls_has_the_bits_of_a_body_without_softening() {
    let rises = [2e-3, 4e-3, 9e-3];
    let states = ["", SOFTENING].map(|softening| {
        let dir = moved(softening, &rises);
        dir.solver("simulate p1.toml -o out").assert_good();
        std::fs::read(dir.path("out/displacement.npy")).unwrap()
    });
    assert!(states[0] == states[1]);
}

/// Inner and outer radius [m].
const A: f64 = 0.01;
const B: f64 = 0.015;

/// An octant of a thick sphere, whose bulk modulus is 1000 shear moduli.
fn sphere(pressure: &str, [end, steps]: [usize; 2]) -> Workdir {
    let body = tag(
        shell_octant(A, B, 6, 3),
        &[
            ("x", &|p| p.x < 1e-9),
            ("y", &|p| p.y < 1e-9),
            ("z", &|p| p.z < 1e-9),
            ("inside", &|p| p.norm() < 0.5 * (A + B)),
        ],
    );
    let dir = Workdir::with(&body);
    let mut scene = format!("mesh = \"body.msh\"\ndegree = 1\n{}{SOFTENING}", silicone(92e6));
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

/// The law has no fatigue beyond the first cycle. At the same largest pressure all inflations are equal; on the
/// way there the first is stiffer, and all others are equal.
#[test]
fn inflations_after_the_first_are_softer_and_equal() {
    let dir = sphere("\"15e3*sin(pi*t)^2\"", [10, 80]);
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
