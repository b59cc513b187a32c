//! `make body` makes what is missing and what has changed, whatever the dates, and says where there is
//! nothing to do. What comes after a scene without a usable result is made, too. The programs are stand-ins that write
//! the file they are asked for: what is tested are the rules of make.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::time::{Duration, SystemTime};

use tests::workdir::{Workdir, make, repository};

/// Writes what make expects of each verb, and what it was called with into the files `calls` and `commands` beside it. A
/// scene with the word `fails` has no usable result.
const STAND_IN: &str = r#"#!/bin/sh
[ "$1" = rules ] && { cat "$(dirname "$0")/rules"; exit; }
echo "$(basename "$0") $1" >> "$(dirname "$0")/calls"
echo "$(basename "$0") $*" >> "$(dirname "$0")/commands"
verb=$1 scene=$2 split=0
while [ $# -gt 1 ]; do
    case $1 in -o) out=$2 ;; --split) split=$2 ;; esac
    shift
done
case $verb in
    model|import) mkdir -p "$out/patches"; touch "$out/patches/skin.stl"; echo "    \"split\": $split.0," > "$out/model.json" ;;
    simulate)
        usable=true
        grep -q fails "$scene" && usable=false
        mkdir -p "$out"
        echo "  \"usable\": $usable," > "$out/report.json"
        $usable ;;
    optimize) mkdir -p "$out"; touch "$out/report.json" ;;
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
        let (code, said, calls) = self.try_make(&[]);
        assert_eq!(code, Some(0), "{said}");
        (said, calls)
    }

    /// The exit code of make with more arguments, too.
    fn try_make(&self, more: &[&str]) -> (Option<i32>, String, Vec<String>) {
        let calls = self.0.path("bin/calls");
        fs::write(&calls, "").unwrap();
        fs::write(self.0.path("bin/commands"), "").unwrap();
        let mut make = make();
        make.arg("--silent").arg(format!("BIN={}", self.0.path("bin").display()));
        if self.0.path("mine/Makefile").exists() {
            make.arg("-C").arg(self.0.path("mine")).current_dir("/");
        } else {
            make.args(["--old-file=setup", "body"]).current_dir(repository());
            make.arg(format!("DIR={}", self.0.path("mine").display()));
        }
        let output = make.args(more).output().unwrap();
        let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        let calls = fs::read_to_string(calls).unwrap().lines().map(str::to_owned).collect();
        (output.status.code(), said, calls)
    }

    /// Gives it the Makefile that `cad2fem new` writes.
    fn with_makefile(self) -> Self {
        let dir = Workdir::new();
        dir.run("cad2fem", "new x").assert_good();
        fs::copy(dir.path("x/Makefile"), self.0.path("mine/Makefile")).unwrap();
        let rules = repository().join("pipelines/folder.mk");
        self.0.write("bin/rules", &rules.display().to_string());
        self
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

/// By the Makefile that `cad2fem new` writes: the same calls as by that of the checkout.
#[test]
fn a_folder_with_a_makefile_makes_itself() {
    assert_eq!(Body::new().with_makefile().make().1, Body::new().make().1);
}

#[test]
fn a_dry_run_lists_what_is_to_be_done_and_no_more() {
    for body in [Body::new(), Body::new().with_makefile()] {
        let bin = body.0.path("bin").display().to_string() + "/";
        let listed = || {
            let (code, said, calls) = body.try_make(&["--dry-run"]);
            assert!(code == Some(0) && calls.is_empty(), "{said} {calls:?}");
            let lines = said.lines().filter_map(|line| line.split_once(&bin));
            lines.map(|(_, call)| call.split(' ').nth(1).unwrap().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(listed().len(), 11);
        body.make();
        assert!(listed().is_empty());
        body.write_old("mine/sim.toml", "# changed\n");
        for _ in 0..2 {
            assert_eq!(listed(), ["simulate", "picture", "report", "pack"], "it changes nothing");
        }
    }
}

#[test]
fn what_comes_after_a_scene_without_usable_result_is_made_and_the_scene_told_each_time() {
    let body = Body::new();
    body.0.write("mine/sim.toml", "fails\n");
    body.0.write("mine/sim.blocked.toml", "");
    let told = |(code, said, calls): (Option<i32>, String, Vec<String>)| {
        assert_eq!(code, Some(2), "{said}");
        let last = said.lines().last().unwrap().to_owned();
        assert!(
            last.contains("*** mine: no usable result")
                && last.contains("/build/baseline: all else"),
            "{said}"
        );
        assert!(body.0.path("mine/build/baseline/report.json").exists());
        (last, calls)
    };
    let (first, calls) = told(body.try_make(&[]));
    for call in ["solver simulate", "fab mold", "fab verify", "cad2fem report", "cad2fem pack"] {
        assert!(called(&calls, call), "{call}: {calls:?}");
    }
    assert!(!first.contains("blocked"), "{first}");
    let (again, calls) = told(body.try_make(&[]));
    assert!(calls.is_empty() && again == first, "{again} {calls:?}");
    // a report that is gone is made again
    fs::remove_file(body.0.path("mine/build/baseline/report.json")).unwrap();
    let (_, calls) = told(body.try_make(&[]));
    assert!(called(&calls, "solver simulate") && !called(&calls, "fab mold"), "{calls:?}");
    body.write_old("mine/sim.toml", "# better\n");
    let (said, calls) = body.make();
    assert!(
        called(&calls, "solver simulate") && said.contains("mine: results in"),
        "{said} {calls:?}"
    );
}

#[test]
fn triangles_are_imported_with_the_angle_of_the_tags() {
    let body = Body::new();
    body.0.write("mine/model.stl", "");
    let (code, said, _) = body.try_make(&[]);
    assert!(
        code == Some(2)
            && said.contains("mine/model.toml")
            && said.contains("which of them is the body?"),
        "{said}"
    );
    fs::remove_file(body.0.path("mine/model.toml")).unwrap();
    let imported = |tags: &str, angle: &str| {
        body.0.write("mine/tags.toml", tags);
        let (_, calls) = body.make();
        assert!(called(&calls, "cad2fem import") && called(&calls, "tagger tag"), "{calls:?}");
        let commands = body.0.text("bin/commands");
        let import = commands.lines().find(|line| line.starts_with("cad2fem import")).unwrap();
        assert!(import.contains(&format!("mine/model.stl {angle}-o ")), "{import}");
    };
    imported("surface = \"../model.stl\"\nsplit = 40\n", "--split 40 ");
    body.0.write("mine/tags.toml", "# other tags\nsplit = 40   # of pick\n");
    let (_, calls) = body.make();
    assert!(!called(&calls, "cad2fem import") && called(&calls, "tagger tag"), "{calls:?}");
    imported("split = 30\n", "--split 30 ");
    // what is no number reaches no shell
    body.0.write("mine/tags.toml", "split = 40$(touch ran)\n");
    body.make();
    assert!(!body.0.text("bin/commands").contains("touch"));
}
