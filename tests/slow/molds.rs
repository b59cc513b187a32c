//! Molds of every scene as it was modelled and of the beam's design, made by the programs:
//! every check holds, and other programs agree. Designs of other bodies take minutes to
//! hours; their molds are judged where `make` has left them, and skipped where not.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock};

use serde_json::Value;
use tests::judges::{self, Solid};
use tests::reported::check_mold;
use tests::skip::skip;
use tests::workdir::{program, python, repository};

use crate::{beam, make, run};

/// Scenes with a mold.toml, and what is cast of each; the gripper is simulated by its half.
const SCENES: [[&str; 2]; 6] = [
    ["beam", "tagged"],
    ["chamber", "tagged"],
    ["finger", "tagged"],
    ["frog", "tagged"],
    ["gripper/safe", "whole"],
    ["worm-segment", "tagged"],
];

/// The folder with the molds of a scene as it was modelled, in build/judged; made once.
fn made([scene, mesh]: [&'static str; 2]) -> PathBuf {
    static MADE: OnceLock<Mutex<BTreeMap<String, PathBuf>>> = OnceLock::new();
    let mut made = MADE.get_or_init(Mutex::default).lock().unwrap();
    let write = || {
        let mesh = format!("build/{scene}/{mesh}.msh");
        make(&mesh);
        let folder = repository().join("build/judged").join(scene);
        let config = repository().join("pipelines").join(scene).join("mold.toml");
        let mut command = Command::new(program("fab"));
        command.args(["mold", "--no-pictures"]).arg(repository().join(mesh));
        run(command.arg("--config").arg(config).arg("--output").arg(&folder));
        folder
    };
    made.entry(scene.into()).or_insert_with(write).clone()
}

/// The folders of molds that are made here.
fn folders() -> Vec<PathBuf> {
    let modelled = SCENES.into_iter().map(made);
    modelled.chain([beam().join("mold")]).collect()
}

/// The folders below a folder that hold a mold.json.
fn molds(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = entries.filter(|p| p.is_dir()).flat_map(|p| molds(&p)).collect();
    found.extend(folder.join("mold.json").exists().then(|| folder.to_path_buf()));
    found
}

/// The printed parts of a mold, and how they are turned into the closed mold.
fn parts(mold: &Path) -> (Vec<Solid>, Vec<[[f64; 3]; 3]>) {
    let text = fs::read_to_string(mold.join("mold.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    check_mold(&report);
    assert_eq!(report["units"], "mm");
    let part = |part: &Value| {
        let solid = Solid {
            file: mold.join(part["file"].as_str().unwrap()),
            name: part["name"].as_str().unwrap().into(),
            volume: part["volume"].as_f64().unwrap(),
        };
        let turn: [[f64; 3]; 3] = serde_json::from_value(part["to_mold"].clone()).unwrap();
        (solid, turn)
    };
    report["parts"].as_array().unwrap().iter().map(part).unzip()
}

/// All checks of `fab verify` hold for the molds in a folder.
fn verify(folder: &Path) {
    let output =
        Command::new(program("fab")).args(["verify", "--all"]).arg(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let failed: Vec<&str> = said.lines().filter(|line| line.starts_with("FAIL")).collect();
    assert!(output.status.success(), "{}: {failed:#?}", folder.display());
    assert!(said.lines().count() > 30, "{said}");
}

/// All checks hold for the molds in a folder, and other programs agree on their parts: slicers, too, slice both files of
/// each without a warning.
fn judge(folder: &Path) {
    verify(folder);
    let (python, scratch) = (python(judges::PACKAGES), tempfile::tempdir().unwrap());
    let [admesh, slicer] = ["admesh", "prusa-slicer"].map(judges::installed);
    for mold in molds(folder) {
        let (parts, places) = parts(&mold);
        if let Some(python) = &python {
            judges::trimesh_and_manifold3d_agree(python, &parts);
            judges::trimesh_reads_3mf(python, &parts, &places);
        }
        if admesh {
            judges::admesh_repairs_nothing(&parts);
        }
        if slicer {
            parts.iter().for_each(|part| judges::prusa_slicer_slices(part, scratch.path()));
        }
    }
}

#[test]
#[ignore = "makes the molds of all scenes: runs in make test-all"]
fn every_mold_is_verified_and_judged_by_others() {
    let folders = folders();
    // Chamber, gripper and worm segment take two, and the beam is there twice.
    let count: usize = folders.iter().map(|folder| molds(folder).len()).sum();
    assert!(count >= 10, "{count}");
    folders.iter().for_each(|folder| judge(folder));
}

#[test]
#[ignore = "judges what `make finger frog gripper` made: runs in make test-all"]
fn molds_of_designs_are_judged() {
    for scene in ["finger", "frog", "gripper"] {
        let folder = repository().join("build").join(scene).join("mold");
        match folder.is_dir() {
            true => judge(&folder),
            false => skip(&format!("build/{scene}/mold is not there: `make {scene}` makes it")),
        }
    }
}
