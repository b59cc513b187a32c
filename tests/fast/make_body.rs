//! `make body` makes what is missing and what has changed, whatever the dates, and says where there is
//! nothing to do. The programs are stand-ins that write the file they are asked for: what is tested
//! are the rules of make.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use std::time::{Duration, SystemTime};

use tests::workdir::{Workdir, program, repository};

/// Writes what make expects of each verb, and its own command line into the file `calls` beside it.
const STAND_IN: &str = r#"#!/bin/sh
[ "$1" = rules ] && { cat "$(dirname "$0")/rules"; exit; }
echo "$(basename "$0") $1" >> "$(dirname "$0")/calls"
verb=$1
while [ $# -gt 1 ]; do [ "$1" = -o ] && out=$2; shift; done
case $verb in
    model) mkdir -p "$out/patches"; touch "$out/model.json" "$out/patches/skin.stl" ;;
    simulate|optimize) mkdir -p "$out"; touch "$out/report.json" ;;
    mold) mkdir -p "$out"; touch "$out/assembled.png" "$out/exploded.png" "$out/plan.json" ;;
    *) mkdir -p "$(dirname "$out")"; touch "$out" ;;
esac
"#;

struct Body(Workdir);

impl Body {
    fn new() -> Self {
        let work = Workdir::new();
        for folder in ["bin", "mine"] {
            fs::create_dir(work.path(folder)).unwrap();
        }
        for name in ["cad2fem", "tagger", "solver", "fab"] {
            let path = format!("bin/{name}");
            work.write(&path, STAND_IN);
            fs::set_permissions(work.path(&path), fs::Permissions::from_mode(0o755)).unwrap();
        }
        for name in ["model", "cad2fem", "tags", "sim", "mold"] {
            work.write(&format!("mine/{name}.toml"), "# as it was\n");
        }
        Self(work)
    }

    /// What make says, and which programs it called.
    fn make(&self) -> (String, Vec<String>) {
        let calls = self.0.path("bin/calls");
        fs::write(&calls, "").unwrap();
        let mut make = Command::new("make");
        make.env_remove("MAKEFLAGS").env_remove("MAKELEVEL").env_remove("MAKEOVERRIDES");
        make.arg("--silent").arg(format!("BIN={}", self.0.path("bin").display()));
        if self.0.path("mine/Makefile").exists() {
            make.arg("-C").arg(self.0.path("mine")).current_dir("/");
        } else {
            make.args(["--old-file=setup", "body"]).current_dir(repository());
            make.arg(format!("DIR={}", self.0.path("mine").display()));
        }
        let output = make.output().unwrap();
        let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        assert!(output.status.success(), "{said}");
        (said, fs::read_to_string(calls).unwrap().lines().map(str::to_owned).collect())
    }

    /// Writes a source as one that was unzipped: it is older than all results.
    fn write_old(&self, name: &str, text: &str) {
        self.0.write(name, text);
        let file = fs::File::options().append(true).open(self.0.path(name)).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(86_400)).unwrap();
    }
}

fn called(calls: &[String], call: &str) -> bool {
    calls.iter().any(|c| c == call)
}

#[test]
fn a_second_make_says_that_there_is_nothing_to_do() {
    let body = Body::new();
    let (said, calls) = body.make();
    assert!(called(&calls, "solver simulate") && called(&calls, "fab mold"), "{calls:?}");
    assert!(!said.contains("nothing to do"), "{said}");
    let (said, calls) = body.make();
    assert!(calls.is_empty(), "{calls:?}");
    assert!(said.contains("nothing to do") && said.contains("report.html"), "{said}");
}

#[test]
fn deleted_results_are_made_again() {
    let body = Body::new();
    body.make();
    for folder in ["baseline", "mold"] {
        fs::remove_dir_all(body.0.path(&format!("mine/build/{folder}"))).unwrap();
    }
    let (_, calls) = body.make();
    assert!(called(&calls, "solver simulate") && called(&calls, "fab mold"), "{calls:?}");
    assert!(!called(&calls, "cad2fem tetmesh"), "{calls:?}");
    fs::remove_file(body.0.path("mine/build/mine.zip")).unwrap();
    let (said, calls) = body.make();
    assert_eq!(calls, ["cad2fem pack"]);
    assert!(said.contains("to send: ") && said.contains("mine/build/mine.zip"), "{said}");
}

#[test]
fn a_source_that_is_older_than_results_counts_when_it_differs() {
    let body = Body::new();
    body.make();
    body.write_old("mine/design.toml", "[shape]\n");
    let (_, calls) = body.make();
    assert!(called(&calls, "solver optimize") && !called(&calls, "cad2fem model"), "{calls:?}");
    body.write_old("mine/sim.toml", "# changed\n");
    let (_, calls) = body.make();
    assert!(called(&calls, "solver simulate") && !called(&calls, "cad2fem tetmesh"), "{calls:?}");
    let (said, calls) = body.make();
    assert!(calls.is_empty() && said.contains("nothing to do"), "{said} {calls:?}");
}

/// By the Makefile that `cad2fem new` writes: the same calls as by that of the checkout, and none the second time.
#[test]
fn a_folder_with_a_makefile_makes_itself() {
    let (body, same) = (Body::new(), Body::new());
    let dir = Workdir::new();
    let mut new = Command::new(program("cad2fem"));
    let new = new.args(["new", "x"]).current_dir(dir.path("")).output();
    assert!(new.unwrap().status.success());
    fs::copy(dir.path("x/Makefile"), body.0.path("mine/Makefile")).unwrap();
    body.0.write("bin/rules", &repository().join("pipelines/folder.mk").display().to_string());
    assert_eq!(body.make().1, same.make().1);
    let (said, calls) = body.make();
    assert!(calls.is_empty() && said.contains("nothing to do"), "{said} {calls:?}");
    body.write_old("mine/sim.toml", "# changed\n");
    let (_, calls) = body.make();
    assert!(called(&calls, "solver simulate") && !called(&calls, "cad2fem tetmesh"), "{calls:?}");
}
