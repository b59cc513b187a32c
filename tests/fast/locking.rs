//! What elements hold back: the estimate of `solver simulate` against the same scene with the next degree,
//! when it is made, and what is said of bodies that hardly change their volume.

use mesh::io::npy;
use serde_json::Value;
use tests::chamber::{self, PROBES};
use tests::workdir::Workdir;

/// A chamber with a law, a load and settings.
fn scene(poisson: &str, load: &str, solver: &str) -> String {
    format!(
        "mesh = \"body.msh\"\n[material]\nkind = \"neo-hookean\"\nyoung = 1e5\npoisson = {poisson}\n\
         [[fixed]]\non = \"seat\"\n[[chamber]]\non = \"cavity\"\n{load}\n{PROBES}[solver]\n{solver}\n"
    )
}

fn workdir() -> Workdir {
    Workdir::with(&chamber::chamber())
}

/// The report of a scene with a degree, and the root of the mean square of its displacement.
fn simulate(dir: &Workdir, scene: &str, degree: usize) -> (Value, f64) {
    dir.write("sim.toml", scene);
    let run = format!("simulate sim.toml --degree {degree} -o out --restart --final-only");
    let report = dir.report(&run);
    let (u, _) = npy::read_f64(&dir.path("out/displacement.npy")).unwrap();
    let mesh = chamber::chamber().mesh;
    let mut volumes = vec![0.0; mesh.vertices.len()];
    for (t, tet) in mesh.tets.iter().enumerate() {
        tet.iter().for_each(|&v| volumes[v] += mesh.volume(t) / 4.0);
    }
    let square = |(v, volume): (usize, &f64)| {
        volume * u[3 * v..3 * v + 3].iter().map(|u| u * u).sum::<f64>()
    };
    let size = volumes.iter().enumerate().map(square).sum::<f64>().sqrt();
    (report, size)
}

/// At small loads the Newton step is all that there is: the estimate is the truth, also where a chamber has
/// a prescribed volume.
#[test]
fn small_displacements_are_estimated_exactly() {
    let dir = workdir();
    let (pressure, pointwise, mean) = ("pressure = 1", "pointwise", "mean");
    for (load, degree, dilatation) in [
        (pressure, 1, pointwise),
        (pressure, 2, pointwise),
        (pressure, 2, mean),
        ("volume_factor = 1.00001", 1, pointwise),
    ] {
        let settings = format!("locking = \"always\"\ndilatation = \"{dilatation}\"");
        let scene = scene("0.49", load, &settings);
        let ((here, before), (next, after)) =
            (simulate(&dir, &scene, degree), simulate(&dir, &scene, degree + 1));
        let found = here["locking"].clone();
        let (missing, expected) = (found["displacement"].as_f64().unwrap(), 1.0 - before / after);
        // strains of 1e-5 leave as much that is not linear
        assert!((missing - expected).abs() < 1e-4, "{load}, {degree}: {missing} {expected}");
        assert!(found["change"].as_f64().unwrap() >= missing.abs() - 1e-9, "{found}");
        assert_eq!(found["degree"], degree);
        let top = |report: &Value| report["probes"]["top"]["value"].as_f64().unwrap();
        let (part, expected) =
            (found["probes"]["top"].as_f64().unwrap(), 1.0 - top(&here) / top(&next));
        assert!((part - expected).abs() < 1e-4, "{load}, {degree}: {part} {expected}");
        if degree == 1 && load == pressure {
            // ν = 0.49 and bending: far more than 5 %
            assert!(missing > 0.2, "{missing}");
        }
    }
}

/// Bodies of the library have 200 shear moduli: their standard elements are compared with those whose volume changes as
/// a whole, on the same nodes.
#[test]
fn nearly_incompressible_bodies_are_compared_with_mean_dilatation() {
    let dir = workdir();
    let ((here, before), (mean, after)) = (
        simulate(&dir, &scene("0.4975", "pressure = 1", ""), 2),
        simulate(&dir, &scene("0.4975", "pressure = 1", "dilatation = \"mean\""), 2),
    );
    assert!(mean["locking"].is_null(), "{mean}");
    let found = &here["locking"];
    assert_eq!(found["compared_with"], "[solver] dilatation = \"mean\"");
    let (missing, expected) = (found["displacement"].as_f64().unwrap(), 1.0 - before / after);
    assert!((missing - expected).abs() < 1e-4 && missing > 0.01, "{missing} {expected}");
    dir.write("sim.toml", &scene("0.4975", "pressure = 1", ""));
    let run = dir.solver("simulate sim.toml --degree 2 -o out --restart");
    assert!(run.stderr.contains("one Newton step with [solver] dilatation"), "{}", run.stderr);
}

#[test]
fn estimates_are_made_where_they_are_due_or_asked_for() {
    let dir = workdir();
    let report = |poisson: &str, solver: &str, degree: usize| {
        simulate(&dir, &scene(poisson, "pressure = 100", solver), degree).0
    };
    let is_made = |report: &Value| report["locking"].is_object();
    assert!(is_made(&report("0.4", "", 1)) && !is_made(&report("0.4", "", 2)));
    assert!(!is_made(&report("0.4", "locking = \"never\"", 1)));
    // 1667 shear moduli
    let firm = report("0.4997", "", 2);
    assert!(is_made(&firm), "{firm}");
    let ratio = firm["locking"]["bulk_over_shear"].as_f64().unwrap();
    assert!((ratio - 1666.0).abs() < 1.0, "{ratio}");
    assert!(!is_made(&report("0.4997", "locking = \"always\"", 3)));
    dir.write("sim.toml", &scene("0.49", "pressure = 100", ""));
    let run = dir.solver("simulate sim.toml --degree 1 -o out --restart");
    for words in ["degree = 1", "% too small", "use degree = 2", "\"top\""] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
}

/// Who asks for a mean dilatation where it changes nothing, or cannot be, is told.
#[test]
fn mean_dilatation_needs_a_degree_and_a_law() {
    let dir = workdir();
    let whole = scene("0.4997", "pressure = 100", "dilatation = \"mean\"");
    dir.write("sim.toml", &whole);
    let run = dir.solver("simulate sim.toml --degree 1 -o out");
    assert!(run.stderr.contains("changes nothing with degree = 1"), "{}", run.stderr);
    dir.write("sim.toml", &whole.replace("neo-hookean", "saint-venant-kirchhoff"));
    let words =
        ["saint-venant-kirchhoff", "no term of the change of volume alone", "mooney-rivlin"];
    dir.solver("simulate sim.toml -o out").assert_refused(2, &words);
}

#[test]
fn a_body_that_hardly_changes_its_volume() {
    let dir = workdir();
    let hasty = "newton_iterations = 3\nsmallest_load_step = 0.9";
    dir.write("sim.toml", &scene("0.49999999", "pressure = 2e4", hasty));
    let run = dir.solver("simulate sim.toml -o out");
    let words =
        ["nearly incompressible", "5.0e7 times the shear modulus", "poisson = 0.4950 to 0.4995"];
    run.assert_refused(1, &words);
    assert!(!run.stderr.contains("supports"), "{}", run.stderr);
    let report = dir.json("out/report.json");
    assert_eq!(report["status"], "no equilibrium");
    assert!(report["failure"]["try"][0].as_str().unwrap().contains("bulk modulus"), "{report}");
}
