//! `make beam` in this checkout: complete and not done twice. `molds.rs` judges its molds.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::SystemTime;

use serde_json::Value;
use tests::workdir::repository;

use crate::make;

/// The folder of results; made once for all tests here.
pub fn beam() -> PathBuf {
    static MADE: Once = Once::new();
    MADE.call_once(|| {
        make("beam");
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

#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn a_second_make_does_nothing() {
    let folder = beam();
    let before = files(&folder);
    make("beam");
    assert!(before == files(&folder), "files changed");
    // atomic writes leave nothing beside what they wrote
    let name = |p: &PathBuf| p.file_name().unwrap().to_string_lossy().into_owned();
    assert!(before.keys().all(|p| !name(p).starts_with(".incomplete")));
    // no part of an earlier mold beside those of this one
    let mold = folder.join("mold");
    let stl = |p: &&PathBuf| p.parent() == Some(&mold) && p.extension().is_some_and(|e| e == "stl");
    let parts = json(&mold.join("mold.json"))["parts"].as_array().unwrap().len();
    assert_eq!(before.keys().filter(stl).count(), parts);
}

#[test]
#[ignore = "makes the beam: runs in make test-all"]
fn every_stage_left_its_results() {
    let folder = beam();
    let large =
        ["volume.msh", "tagged.msh", "baseline/result.vtu", "optimize/design.msh", "report.html"];
    for file in large {
        assert!(folder.join(file).metadata().unwrap().len() > 1000, "{file}");
    }
    let is_picture = |p: &PathBuf| p.extension().is_some_and(|e| e == "png" || e == "svg");
    assert!(files(&folder.join("pictures")).keys().all(is_picture));
    assert_eq!(json(&folder.join("baseline/report.json"))["status"], "ok");
    let report = json(&folder.join("optimize/report.json"));
    let [before, after] =
        ["objective_before", "objective_after"].map(|k| report[k].as_f64().unwrap());
    eprintln!("beam: objective {before:.4e} -> {after:.4e}");
    // what the issue asks of the frog
    assert!(after < 0.5 * before, "{before} {after}");
}
