//! Every body that `cad2fem new` writes is made in an empty folder, from its model to its page.

use std::process::Command;

use cad2fem::template::TEMPLATES;
use tests::workdir::{Workdir, program, repository};

fn make_in_empty_folder(name: &str) {
    let dir = Workdir::new();
    let new = Command::new(program("cad2fem"))
        .args(["new", "mine", "--like", name])
        .current_dir(dir.path(""))
        .output()
        .unwrap();
    assert!(new.status.success(), "{new:?}");
    let folder = dir.path("mine");
    crate::make(&format!("body DIR={}", folder.display()));
    assert!(folder.join("build/report.html").exists());
    let checks = dir.text("mine/build/mold.checks.txt");
    assert!(checks.lines().count() > 10 && !checks.contains("FAIL"), "{checks}");
    assert_eq!(dir.json("mine/build/baseline/report.json")["usable"], true);
    assert!(!repository().join("build/mine").exists());
}

#[test]
#[ignore = "makes the blank, beam and finger, ten minutes: runs in make test-all"]
fn every_template_is_made() {
    TEMPLATES.iter().for_each(|template| make_in_empty_folder(template.name));
}
