//! The molds of all scenes that were made: every check holds, and other programs agree.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tests::workdir::{program, python, repository};

/// Scenes whose molds are made by `make all`.
const SCENES: [&str; 6] = ["beam", "chamber", "finger", "frog", "gripper", "worm-segment"];

/// Folders of molds that are there; says which are not.
fn made() -> Vec<PathBuf> {
    let folder = |scene: &&str| {
        let folder = repository().join("build").join(scene).join("mold");
        let made = folder.is_dir();
        if !made {
            eprintln!("SKIPPED: {scene}: no molds; make {scene}");
        }
        made.then_some(folder)
    };
    SCENES.iter().filter_map(folder).collect()
}

/// The folders below a folder that hold a mold.json.
fn molds(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = entries.filter(|p| p.is_dir()).flat_map(|p| molds(&p)).collect();
    found.extend(folder.join("mold.json").exists().then(|| folder.to_path_buf()));
    found
}

/// Printed parts of all molds: file and volume [mm³] as mold.json has them.
fn parts() -> Vec<(PathBuf, f64)> {
    let mut found = Vec::new();
    for mold in made().iter().flat_map(|folder| molds(folder)) {
        let text = fs::read_to_string(mold.join("mold.json")).unwrap();
        let report: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(report["units"], "mm");
        for part in report["parts"].as_array().unwrap() {
            let file = mold.join(part["file"].as_str().unwrap());
            found.push((file, part["volume"].as_f64().unwrap()));
        }
    }
    found
}

#[test]
#[ignore = "needs molds that were made: runs in make test-all"]
fn every_mold_is_verified() {
    for folder in made() {
        let output = Command::new(program("fab")).arg("verify").arg(&folder).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let failed: Vec<&str> = said.lines().filter(|line| line.starts_with("FAIL")).collect();
        assert!(output.status.success(), "{}: {failed:#?}", folder.display());
        assert!(said.lines().count() > 30, "{said}");
    }
}

#[test]
#[ignore = "needs molds that were made: runs in make test-all"]
fn trimesh_and_manifold3d_agree_on_every_part() {
    const JUDGE: &str = "
import sys, numpy, trimesh, manifold3d
for path in sys.argv[1:]:
    m = trimesh.load(path)
    solid = manifold3d.Manifold(manifold3d.Mesh64(
        numpy.asarray(m.vertices, numpy.float64), numpy.asarray(m.faces, numpy.uint64)))
    print(m.is_watertight and m.is_winding_consistent, m.volume, solid.status().name, solid.volume())
";
    let Some(python) = python("numpy, trimesh, manifold3d") else { return };
    let parts = parts();
    let paths = parts.iter().map(|part| &part.0);
    let output = Command::new(python).args(["-c", JUDGE]).args(paths).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(said.lines().count(), parts.len(), "{}", String::from_utf8_lossy(&output.stderr));
    for (line, (path, volume)) in said.lines().zip(&parts) {
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!([words[0], words[2]], ["True", "NoError"], "{}: {line}", path.display());
        for other in [words[1], words[3]] {
            let other: f64 = other.parse().unwrap();
            assert!((other / volume - 1.0).abs() < 1e-5, "{}: {line}, {volume}", path.display());
        }
    }
}

#[test]
#[ignore = "needs molds that were made: runs in make test-all"]
fn admesh_repairs_no_part() {
    if Command::new("admesh").arg("--version").output().is_err() {
        eprintln!("SKIPPED: admesh is not installed");
        return;
    }
    for (path, _) in parts() {
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

/// Both files of every part are sliced without a warning.
#[test]
#[ignore = "needs molds that were made: runs in make test-all"]
fn prusa_slicer_slices_every_part() {
    if Command::new("prusa-slicer").arg("--help").output().is_err() {
        eprintln!("SKIPPED: prusa-slicer is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (path, _) in
        parts().iter().flat_map(|(p, v)| [(p.clone(), *v), (p.with_extension("3mf"), *v)])
    {
        let mut command = Command::new("prusa-slicer");
        command.args(["--export-gcode", "--center", "125,105", "--layer-height", "0.2"]);
        command.args(["--bed-shape", "0x0,250x0,250x210,0x210", "--max-print-height", "220"]);
        command.args(["--support-material", "--output"]).arg(folder.path().join("part.gcode"));
        let output = command.arg(&path).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).to_lowercase();
        assert!(output.status.success(), "{}: {said}", path.display());
        for word in ["warning", "error", "repaired", "not manifold"] {
            assert!(!said.contains(word), "{}: {said}", path.display());
        }
    }
}
