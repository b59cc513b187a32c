//! Every body that `cad2fem new` writes is made in an empty folder, from its model to its page; those that take
//! half an hour only up to their first states and molds.

use std::path::PathBuf;
use std::process::Command;

use cad2fem::template::TEMPLATES;
use mesh::Vec3;
use mesh::io::write_surface;
use mesh::solid::Solid;
use tests::workdir::{Workdir, program, repository};

/// A folder like a template, and where it is.
fn new_folder(name: &str) -> (Workdir, PathBuf) {
    let dir = Workdir::new();
    dir.run("cad2fem", &format!("new mine --like {name}")).assert_good();
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
    // a second make changes nothing, and says so
    assert!(crate::make(&format!("-C {}", folder.display())).contains("nothing to do"));
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

/// Tags of a bar that is held at x = 0, where its chamber opens.
const TAGS: &str = r#"
[[tag]]
name = "fixed"
plane = { point = [1e-4, 0, 0], normal = [-1, 0, 0] }

[[tag]]
name = "tip"
plane = { point = [0.0399, 0, 0], normal = [1, 0, 0] }

[[tag]]
name = "cavity"
box = { min = [-1, 0.0039, 0.0039], max = [0.0341, 0.0121, 0.0101] }
pressure = true
rim = "fixed"

[[tag]]
name = "skin"
component = 0
"#;

#[test]
#[ignore = "meshes, simulates and casts a bar twice, two minutes: runs in make test-all"]
fn a_body_imported_by_hand_is_made_again_from_its_package() {
    let (dir, folder) = new_folder("blank");
    for own in ["model.toml", "sim.blocked.toml"] {
        std::fs::remove_file(folder.join(own)).unwrap();
    }
    dir.write("mine/tags.toml", TAGS);
    let cube = |name: &str, low: [f64; 3], high: [f64; 3]| {
        let cube = Solid::cube(&Vec3::from(low), &Vec3::from(high));
        write_surface(&dir.path(name), &cube.to_surface()).unwrap();
    };
    cube("body.stl", [0.0; 3], [40.0, 16.0, 14.0]);
    cube("air.stl", [-5.0, 4.0, 4.0], [34.0, 12.0, 10.0]);
    let import = "import body.stl --subtract air.stl --split 40 -o mine/build/model";
    dir.run("cad2fem", import).assert_good();
    crate::make(&format!("-C {}", folder.display()));
    crate::run(
        Command::new("python3")
            .args(["-m", "zipfile", "-e", "mine/build/mine.zip", "got"])
            .current_dir(dir.path("")),
    );
    let sources = dir.path("got/mine/sources");
    for cad in ["body.stl", "air.stl"] {
        assert_eq!(
            std::fs::read(sources.join("cad").join(cad)).unwrap(),
            std::fs::read(dir.path(cad)).unwrap()
        );
    }
    // the Makefile of the package takes the programs in PATH
    let bin = program("cad2fem").parent().unwrap().display().to_string();
    crate::make(&format!("-C {} BIN={bin}", sources.display()));
    assert_eq!(dir.json("got/mine/sources/build/baseline/report.json")["usable"], true);
    assert!(
        sources.join("build/mold.checks.txt").exists()
            && sources.join("build/sources.zip").exists()
    );
}
