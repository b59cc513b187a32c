//! `make body` makes what is missing and what has changed, whatever the dates, and says where there is
//! nothing to do. What comes after a scene without a usable result is made, too. The programs are stand-ins that write
//! the file they are asked for: what is tested are the rules of make.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use std::time::{Duration, SystemTime};

use tests::workdir::{Workdir, repository};

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
        let mut make = Command::new("make");
        make.env_remove("MAKEFLAGS").env_remove("MAKELEVEL").env_remove("MAKEOVERRIDES");
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
        let new = dir.command_of("cad2fem", "new x").output().unwrap();
        assert!(new.status.success(), "{new:?}");
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

/// By the Makefile that `cad2fem new` writes: the same calls as by that of the checkout, and none the second time.
#[test]
fn a_folder_with_a_makefile_makes_itself() {
    let (body, same) = (Body::new().with_makefile(), Body::new());
    assert_eq!(body.make().1, same.make().1);
    let (said, calls) = body.make();
    assert!(calls.is_empty() && said.contains("nothing to do"), "{said} {calls:?}");
    body.write_old("mine/sim.toml", "# changed\n");
    let (_, calls) = body.make();
    assert!(called(&calls, "solver simulate") && !called(&calls, "cad2fem tetmesh"), "{calls:?}");
}

#[test]
fn a_dry_run_lists_what_is_to_be_done_and_no_more() {
    for body in [Body::new(), Body::new().with_makefile()] {
        let listed = || {
            let (code, said, calls) = body.try_make(&["--dry-run"]);
            assert!(code == Some(0) && calls.is_empty(), "{said} {calls:?}");
            let programs =
                ["cad2fem ", "tagger ", "solver ", "fab "].map(|name| format!("/bin/{name}"));
            let lines = said.lines().filter(|line| programs.iter().any(|name| line.contains(name)));
            let verb = |line: &str| {
                line.split("/bin/").nth(1).unwrap().split(' ').nth(1).unwrap().to_owned()
            };
            (lines.map(verb).collect::<Vec<_>>(), said)
        };
        assert_eq!(listed().0.len(), 11);
        body.make();
        let (verbs, said) = listed();
        assert!(verbs.is_empty() && !said.contains("nothing to do,"), "{said}");
        body.write_old("mine/sim.toml", "# changed\n");
        assert_eq!(listed().0, ["simulate", "picture", "report", "pack"]);
        assert_eq!(listed().0.len(), 4, "it changes nothing");
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

/// By names and links that lie in the results already.
#[test]
fn results_of_others_run_nothing_and_lead_nowhere() {
    let body = Body::new().with_makefile();
    body.make();
    let odd = ["`{touch,ran}`", "$(touch ran)", "x;touch ran", "a --target-directory=build"];
    for name in odd {
        body.0.write(&format!("mine/build/model/patches/{name}.stl"), "");
        let folder = format!("mine/build/mold/{name}");
        fs::create_dir(body.0.path(&folder)).unwrap();
        for picture in ["exploded", "assembled"] {
            body.0.write(&format!("{folder}/{picture}.png"), "");
        }
    }
    // older than results, so that these are made again
    body.write_old("victim", "mine");
    fs::remove_dir_all(body.0.path("mine/build/pictures")).unwrap();
    fs::create_dir(body.0.path("mine/build/pictures")).unwrap();
    for link in ["pictures/mold.png", "pictures/mold-closed.png", "done", ".sources/sim.toml"] {
        let link = body.0.path(&format!("mine/build/{link}"));
        let _ = fs::remove_file(&link);
        std::os::unix::fs::symlink(body.0.path("victim"), link).unwrap();
    }
    body.make();
    assert_eq!(body.0.text("victim"), "mine");
    assert!(!body.0.path("mine/ran").exists() && !body.0.path("ran").exists());
    let names = body.0.files("mine/build/pictures");
    for number in ["", "2", "3", "4", "5"] {
        assert!(names.contains(&format!("mold{number}.png")), "{names:?}");
    }
    let commands = body.0.text("bin/commands");
    let picture = commands.lines().find(|line| line.contains(": regions")).unwrap();
    assert!(odd.iter().all(|name| picture.contains(&format!("patches/{name}.stl"))), "{picture}");
    // nor does a folder that is one
    fs::remove_dir_all(body.0.path("mine/build/.sources")).unwrap();
    std::os::unix::fs::symlink(body.0.path("bin"), body.0.path("mine/build/.sources")).unwrap();
    let (code, said, _) = body.try_make(&[]);
    assert!(code == Some(2) && said.contains("lies behind a link"), "{said}");
    assert!(!body.0.path("bin/sim.toml").exists());
}
