//! Every body that `cad2fem new` writes is made in an empty folder, from its model to its page; those that take
//! half an hour only up to their first states and molds.

use std::path::PathBuf;
use std::process::Command;

use cad2fem::template::TEMPLATES;
use tests::workdir::{Workdir, program, repository};

/// A folder like a template, and where it is.
fn new_folder(name: &str) -> (Workdir, PathBuf) {
    let dir = Workdir::new();
    let new = Command::new(program("cad2fem"))
        .args(["new", "mine", "--like", name])
        .current_dir(dir.path(""))
        .output()
        .unwrap();
    assert!(new.status.success(), "{new:?}");
    let folder = dir.path("mine");
    (dir, folder)
}

fn make_in_empty_folder(name: &str) {
    let (dir, folder) = new_folder(name);
    crate::make(&format!("-C {}", folder.display()));
    assert!(folder.join("build/report.html").exists() && folder.join("build/mine.zip").exists());
    check_mold(&dir);
    assert_eq!(dir.json("mine/build/baseline/report.json")["usable"], true);
    assert!(!repository().join("build/mine").exists());
}

fn check_mold(dir: &Workdir) {
    let checks = dir.text("mine/build/mold.checks.txt");
    assert!(checks.lines().count() > 10 && !checks.contains("FAIL"), "{checks}");
}

/// Those that take longer.
const LONG: [&str; 4] = ["arm", "pneunet", "frog", "gripper"];

#[test]
#[ignore = "makes all but the longest, some twenty minutes: runs in make test-all"]
fn every_short_template_is_made() {
    let short = TEMPLATES.iter().filter(|template| !LONG.contains(&template.name));
    short.for_each(|template| make_in_empty_folder(template.name));
}

#[test]
#[ignore = "meshes arm, frog and gripper, casts the PneuNet and simulates all, some minutes: runs in make test-all"]
fn long_templates_begin() {
    for (name, last) in [
        ("arm", "baseline/report.json"),
        ("pneunet", "mold.checks.txt"),
        ("frog", "pictures/baseline.png"),
        ("gripper", "pictures/gripping-baseline.png"),
    ] {
        let (dir, folder) = new_folder(name);
        let folder = folder.display();
        crate::make(&format!("-C {folder} build/baseline/report.json build/{last}"));
        assert_eq!(dir.json("mine/build/baseline/report.json")["usable"], true);
        if name == "pneunet" {
            check_mold(&dir);
            let tags = dir.json("mine/build/baseline/report.json")["membranes"].clone();
            assert!(tags.to_string().contains("paper"), "{tags}");
        }
    }
}
