//! The beam and the frog by CalculiX: the same mesh, loads and degree, and displacements beside those of `solver
//! simulate`.

use std::path::{Path, PathBuf};
use std::process::Command;

use tests::calculix;
use tests::skip::skip;
use tests::workdir::{Workdir, program, python, repository};

use crate::{make, run};

/// A law that has the constants of the scene and the volumetric term of CalculiX.
const SAME_LAW: &str = "material.kind=mooney-rivlin-quadratic";

/// The largest difference over the largest displacement, of a scene with a change and a degree.
fn difference(scene: &Path, degree: usize, changes: &[&str]) -> f64 {
    let dir = Workdir::new();
    let solver = |verb: &str| {
        let mut command = Command::new(program("solver"));
        command
            .arg(verb)
            .arg(scene)
            .args(["--degree", &degree.to_string()])
            .current_dir(dir.path(""));
        changes.iter().for_each(|change| _ = command.args(["--set", change]));
        command
    };
    run(solver("export").args(["-o", "deck.inp"]));
    run(solver("simulate").args(["-o", "run", "--final-only", "--no-certify"]));
    calculix::apart(&dir, "deck", "run")
}

/// A scene of `pipelines` whose mesh is made; none where CalculiX or a mesher is missing.
fn scene(body: &str) -> Option<PathBuf> {
    python("wildmeshing")?;
    if !calculix::is_installed() {
        skip("ccx (CalculiX) is not installed");
        return None;
    }
    make(&format!("build/{body}/tagged.msh"));
    Some(repository().join("pipelines").join(body).join("sim.toml"))
}

/// Both programs integrate elements of degree 1 alike, so that only convergence differs.
#[test]
#[ignore = "runs CalculiX for a minute: runs in make test-all"]
fn the_beam_and_the_frog_move_alike() {
    for body in ["beam", "frog"] {
        let Some(scene) = scene(body) else { return };
        let apart = difference(&scene, 1, &[SAME_LAW]);
        assert!(apart < 1e-4, "{body}: {apart:.1e}");
    }
}

/// CalculiX has 4 points in an element of degree 2, and we 14.
#[test]
#[ignore = "runs CalculiX for minutes: runs in make test-all"]
fn the_beam_of_degree_2_moves_nearly_alike() {
    let Some(scene) = scene("beam") else { return };
    for (law, changes, within) in
        [("the same law", &[SAME_LAW][..], 1e-2), ("its own law", &[], 2e-2)]
    {
        let apart = difference(&scene, 2, changes);
        assert!(apart < within, "beam, degree 2, {law}: {apart:.1e}");
    }
}
