//! `make beam` in this checkout: complete, not done twice, and molds that other
//! programs accept.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Once;
use std::time::SystemTime;

use serde_json::Value;
use tests::workdir::{program, python, repository};

/// Runs `make beam` and returns what it said.
fn make_beam() -> String {
    let mut command = Command::new("make");
    // a make that runs these tests must not hand its own flags down
    command.env_remove("MAKEFLAGS").env_remove("MAKELEVEL").env_remove("MAKEOVERRIDES");
    let output = command.arg("beam").current_dir(repository()).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    assert!(output.status.success(), "{said}");
    said
}

/// The folder of results; made once for all tests here.
fn beam() -> PathBuf {
    static MADE: Once = Once::new();
    MADE.call_once(|| {
        make_beam();
    });
    repository().join("build/beam")
}

/// Every file below a folder with the time of its last change.
fn files(folder: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.insert(path, entry.metadata().unwrap().modified().unwrap());
        }
    }
    found
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Parts and the cast body: file and volume [mm³] as mold.json has them.
fn solids() -> Vec<(PathBuf, f64)> {
    let folder = beam().join("mold");
    let report = json(&folder.join("mold.json"));
    assert_eq!(report["units"], "mm");
    let mut solids = report["parts"].as_array().unwrap().clone();
    assert!(solids.len() >= 3, "shells and a core");
    solids.push(report["cast"].clone());
    let solid =
        |s: &Value| (folder.join(s["file"].as_str().unwrap()), s["volume"].as_f64().unwrap());
    solids.iter().map(solid).collect()
}

#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn a_second_make_does_nothing() {
    let folder = beam();
    let before = files(&folder);
    make_beam();
    assert!(before == files(&folder), "files changed");
    // atomic writes leave nothing beside what they wrote
    let name = |p: &PathBuf| p.file_name().unwrap().to_string_lossy().into_owned();
    assert!(before.keys().all(|p| !name(p).starts_with(".incomplete")));
    let own = |folder: &Path| {
        let stl =
            |p: &&PathBuf| p.parent() == Some(folder) && p.extension().is_some_and(|e| e == "stl");
        before.keys().filter(stl).count()
    };
    // no part of an earlier mold beside those of this one
    assert_eq!(own(&folder.join("mold")), solids().len() - 1);
}

#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn every_stage_left_its_results() {
    let folder = beam();
    for file in ["volume.msh", "tagged.msh", "baseline/result.vtu", "optimize/design.msh"] {
        assert!(folder.join(file).metadata().unwrap().len() > 1000, "{file}");
    }
    assert!(files(&folder.join("pictures")).keys().all(|p| p.extension().unwrap() == "png"));
    assert_eq!(json(&folder.join("baseline/report.json"))["status"], "ok");
    let report = json(&folder.join("optimize/report.json"));
    let [before, after] =
        ["objective_before", "objective_after"].map(|k| report[k].as_f64().unwrap());
    eprintln!("beam: objective {before:.4e} -> {after:.4e}");
    // what the issue asks of the frog
    assert!(after < 0.5 * before, "{before} {after}");
}

#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn fab_verify_passes() {
    let output =
        Command::new(program("fab")).arg("verify").arg(beam().join("mold")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && said.lines().count() > 5, "{said}");
}

/// Slopes of 2 ± 0.1 at the start and at the design; exit code 1 otherwise.
#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn gradients_are_exact_at_the_start_and_at_the_design() {
    let design = beam().join("optimize/design.msh");
    for arguments in [vec![], vec!["--mesh".as_ref(), design.as_os_str()]] {
        let mut command = Command::new(program("solver"));
        command.arg("check").arg(repository().join("pipelines/beam/design.toml"));
        // the design is near the limits of validity: short steps
        command.args(["--motion", "3e-5"]);
        let output = command.args(&arguments).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).into_owned();
        assert!(output.status.success(), "{said}");
        assert_eq!(said.matches("slope ").count(), 2, "{said}");
    }
}

/// trimesh and manifold3d agree with mold.json; admesh has nothing to repair;
/// a slicer finds something to print on its bed.
#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn trimesh_and_manifold3d_accept_the_molds() {
    const JUDGE: &str = "
import sys, numpy, trimesh, manifold3d
for path in sys.argv[1:]:
    m = trimesh.load(path)
    solid = manifold3d.Manifold(manifold3d.Mesh64(
        numpy.asarray(m.vertices, numpy.float64), numpy.asarray(m.faces, numpy.uint64)))
    print(m.is_watertight and m.is_winding_consistent, m.volume, solid.status().name, solid.volume())
";
    let Some(python) = python("numpy, trimesh, manifold3d") else { return };
    let solids = solids();
    let paths = solids.iter().map(|s| &s.0);
    let output = Command::new(python).args(["-c", JUDGE]).args(paths).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.lines().count(), solids.len(), "{complaint}");
    for (line, (path, volume)) in said.lines().zip(&solids) {
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!([words[0], words[2]], ["True", "NoError"], "{}: {line}", path.display());
        for other in [words[1], words[3]] {
            let other: f64 = other.parse().unwrap();
            assert!((other / volume - 1.0).abs() < 1e-6, "{}: {line}, {volume}", path.display());
        }
    }
}

#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn admesh_repairs_nothing() {
    if Command::new("admesh").arg("--version").output().is_err() {
        eprintln!("SKIPPED: admesh is not installed");
        return;
    }
    for (path, _) in solids() {
        let output = Command::new("admesh").arg(&path).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        for repair in [
            "Degenerate facets",
            "Edges fixed",
            "Facets removed",
            "Facets added",
            "Facets reversed",
        ] {
            let line =
                said.lines().find(|l| l.contains(repair)).unwrap_or_else(|| panic!("{said}"));
            assert_eq!(line.split_whitespace().last(), Some("0"), "{}: {line}", path.display());
        }
    }
}

#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn a_slicer_prints_the_molds() {
    let Some(slicer) = ["prusa-slicer", "slic3r"]
        .into_iter()
        .find(|s| Command::new(s).arg("--help").output().is_ok())
    else {
        eprintln!("SKIPPED: neither prusa-slicer nor slic3r is installed");
        return;
    };
    let parts = solids();
    for (path, _) in &parts[..parts.len() - 1] {
        let output = Command::new(slicer).arg("--info").arg(path).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{}: {said}", path.display());
        assert!(said.contains("manifold = yes"), "{}: {said}", path.display());
    }
}
