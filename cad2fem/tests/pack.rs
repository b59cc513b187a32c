//! Results and sources as one file to send.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Read as _};
use std::time::{Duration, SystemTime};

use zip::ZipArchive;

use crate::support::Workdir;

/// A folder of results with a page, and one of sources with its results in it.
fn results() -> Workdir {
    let dir = Workdir::new();
    let write = |path: &str, text: &str| {
        let path = dir.path(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    let mold = r#"{"program": "fab 9", "input": {"path": "../tagged.msh", "sha256": "c0ffee"}}"#;
    write("mine/build/mold/plan.json", r#"{"molds": [{"folder": "."}]}"#);
    write("mine/build/mold/mold.json", mold);
    for name in ["upper.stl", "upper.3mf", "upper.ini", "cast.html", ".upper.stl.tmp"] {
        write(&format!("mine/build/mold/{name}"), name);
    }
    write("mine/build/mold.checks.txt", "ok  a  b  c\n");
    write("mine/build/run/report.json", r#"{"program": "solver 9"}"#);
    write("mine/build/run/step_000.vtu", "not to be sent");
    write("mine/build/run/curve.csv", "load [1]\n1\n");
    write("mine/build/pictures/mold.png", "PNG");
    write("mine/build/report.html", "<!doctype html>");
    for name in ["model.toml", "parts/rib.step", "film.mp4", ".secret.toml"] {
        write(&format!("mine/{name}"), name);
    }
    dir
}

const PACK: &str = "pack mine/build --sources mine -o mine/build/mine.zip";

fn entries(bytes: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut found = BTreeMap::new();
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).unwrap();
        let name = file.name().unwrap().into_owned();
        let mut content = Vec::new();
        file.read_to_end(&mut content).unwrap();
        found.insert(name, content);
    }
    found
}

#[test]
fn a_package_has_results_and_sources_and_is_always_the_same() {
    let dir = results();
    // a Makefile of others is a program, and the name of a scene may be one
    dir.write("mine/Makefile", "$(shell touch ran)");
    dir.write("mine/rules.mk", "$(shell touch ran)");
    dir.write("mine/sim.`touch ran`.toml", "");
    let run = dir.run(PACK);
    run.says("mine.zip: ");
    run.says("sources/sim.`touch ran`.toml: left out of the package, as make or a shell may take the '`'");
    let first = fs::read(dir.path("mine/build/mine.zip")).unwrap();
    let packed = entries(&first);
    let names: Vec<&str> = packed.keys().map(String::as_str).collect();
    let expected = [
        "mine/SHA256SUMS",
        "mine/mold.checks.txt",
        "mine/mold/cast.html",
        "mine/mold/mold.json",
        "mine/mold/plan.json",
        "mine/mold/upper.3mf",
        "mine/mold/upper.ini",
        "mine/mold/upper.stl",
        "mine/pictures/mold.png",
        "mine/report.html",
        "mine/run/curve.csv",
        "mine/run/report.json",
        "mine/sources/Makefile",
        "mine/sources/model.toml",
        "mine/sources/parts/rib.step",
        "mine/versions.txt",
    ];
    assert_eq!(names, expected);
    let text = |name: &str| String::from_utf8(packed[name].clone()).unwrap();
    let versions = text("mine/versions.txt");
    for words in ["solver 9", "fab 9", "c0ffee  ../tagged.msh"] {
        assert!(versions.contains(words), "{words}: {versions}");
    }
    let makefile = text("mine/sources/Makefile");
    assert!(makefile.contains("include $(or $(shell $(BIN)/cad2fem rules)"), "{makefile}");
    assert!(!makefile.contains("touch") && !makefile.contains("LIKE"), "{makefile}");
    let sums = text("mine/SHA256SUMS");
    assert_eq!(sums.lines().count(), expected.len() - 1);
    for line in sums.lines() {
        let (sum, name) = line.split_once("  ").unwrap();
        assert_eq!(program::sha256(&packed[&format!("mine/{name}")]), sum, "{name}");
    }
    // another day, the same bits
    let model = fs::File::options().append(true).open(dir.path("mine/model.toml")).unwrap();
    model.set_modified(SystemTime::now() - Duration::from_secs(86_400)).unwrap();
    dir.run(PACK).succeeds();
    assert!(fs::read(dir.path("mine/build/mine.zip")).unwrap() == first);
    dir.write("mine/model.toml", "changed");
    dir.run(PACK).succeeds();
    assert!(fs::read(dir.path("mine/build/mine.zip")).unwrap() != first);
}

#[test]
fn a_model_made_by_hand_is_packed_with_its_cad() {
    let dir = results();
    fs::remove_file(dir.path("mine/model.toml")).unwrap();
    for (name, text) in
        [("air.step", "air"), ("mine/parts/body.step", "body"), ("gone.step", "gone")]
    {
        dir.write(name, text);
    }
    let file = |path: &str, text: &str| {
        format!(
            r#"{{"path": "../../../{path}", "sha256": "{}", "unit": "mm"}}"#,
            program::sha256(text.as_bytes())
        )
    };
    let list =
        [file("mine/parts/body.step", "body"), file("air.step", "air"), file("gone.step", "other")];
    fs::create_dir_all(dir.path("mine/build/model/patches")).unwrap();
    let report = format!(r#"{{"import": {{"files": [{}], "changes": []}}}}"#, list.join(", "));
    dir.write("mine/build/model/model.json", &report);
    for name in ["model.stl", "patches/air.stl"] {
        dir.write(&format!("mine/build/model/{name}"), name);
    }
    dir.write("mine/Makefile", "LIKE := gripper\n");
    let run = dir.run(PACK);
    run.says("gone.step is not what this result was made from");
    let packed = entries(&fs::read(dir.path("mine/build/mine.zip")).unwrap());
    let names: Vec<&str> =
        packed.keys().filter_map(|name| name.strip_prefix("mine/sources/")).collect();
    let expected = [
        "Makefile",
        "build/model/model.json",
        "build/model/model.stl",
        "build/model/patches/air.stl",
        "cad/air.step",
        "parts/body.step",
        "parts/rib.step",
        "rules.mk",
    ];
    assert_eq!(names, expected);
    // the rules of that body, which came with this program
    assert!(packed["mine/sources/rules.mk"].starts_with(b"# What makes the gripper"));
    assert!(packed["mine/sources/Makefile"].windows(16).any(|text| text == b"LIKE := gripper\n"));
}

#[test]
fn what_cannot_be_packed_leaves_the_package_as_it_was() {
    let dir = results();
    dir.run("pack mine/build -o mine.tar").fails(2, "must end with .zip");
    dir.run("pack mine -o mine.zip").fails(2, "nothing to show");
    dir.run("pack mine/build --sources nowhere -o mine.zip").fails(2, "nowhere");
    dir.run(PACK).succeeds();
    let before = fs::read(dir.path("mine/build/mine.zip")).unwrap();
    fs::remove_file(dir.path("mine/build/report.html")).unwrap();
    dir.run(PACK).fails(2, "cad2fem report mine/build -o mine/build/report.html");
    assert!(fs::read(dir.path("mine/build/mine.zip")).unwrap() == before);
    assert!(!dir.path("mine.zip").exists() && !dir.path("mine.tar").exists());
}
