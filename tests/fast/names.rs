//! Names that are given to make, or that it finds: what make or the shell take for their own is refused, before any
//! rule is read and any shell runs.

use std::fs;
use std::path::Path;
use std::process::Output;

use tests::workdir::{self, Workdir, repository};

/// What make reads in the checkout, with no body.
const RULES: [&str; 6] = [
    "Makefile",
    "pipelines/chain.mk",
    "pipelines/rules.mk",
    "pipelines/folder.mk",
    "pipelines/gripper/rules.mk",
    "pipelines/validation/rules.mk",
];

fn make_in(folder: &Path, arguments: &[&str]) -> Output {
    workdir::make().arg("--dry-run").args(arguments).current_dir(folder).output().unwrap()
}

fn make(arguments: &[&str]) -> Output {
    make_in(&repository(), arguments)
}

#[test]
fn names_with_a_meaning_to_make_or_the_shell_are_refused() {
    let dir = Workdir::new();
    let ran = dir.path("ran").display().to_string();
    let code = format!("$(shell touch {ran})");
    let mut names = vec![code.clone(), format!("`touch {ran}`"), format!("x; touch {ran}")];
    names.extend(["-x", "--file=x", "x ", "x\ny", "x\ty"].map(str::to_owned));
    for c in "$;:*?[]{}()<>&|!'\"`\\~%=^# ".chars() {
        names.push(format!("x{c}y"));
    }
    for name in &names {
        // dry or not, a function of make would run while the rules are read
        let output = make(&["body", &format!("DIR={name}")]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert_eq!(said.lines().count(), 1, "{name}: {said}");
        assert!(said.contains("*** DIR: a name has "), "{name}: {said}");
        assert!(output.stdout.is_empty(), "{name}: nothing is made");
    }
    for name in ["x", "./x/", "x-y_z.1/a,b", "\u{e9}t\u{e9}/x@y", "/tmp/x+y"] {
        let said = make(&["body", &format!("DIR={name}")]).stdout;
        let said = String::from_utf8(said).unwrap();
        assert!(said.contains("there is no model.toml"), "{name}: {said}");
    }
    for variable in ["BODY", "SWEEP", "QUALITY", "RETRY", "TARGET", "PREFIX", "DESTDIR", "PYTHON"] {
        let output = make(&["sweep", &format!("{variable}={code}")]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(&format!("*** {variable}: a name has $ ( )")), "{variable}: {said}");
    }
    assert!(!dir.path("ran").exists());
}

/// Parts of names of files that would run as code, or that make parts in two.
const HOSTILE: [&str; 7] = [
    "`{touch,ran}`",
    "$(shell touch ran)",
    "$(touch ran)",
    "x;touch ran;",
    "x:\n\ttouch ran\nx",
    "x y",
    "\u{e9}\u{1b}[31m",
];

/// A folder with the rules.
fn rules() -> Workdir {
    let dir = Workdir::new();
    for file in RULES {
        fs::create_dir_all(dir.path(file).parent().unwrap()).unwrap();
        fs::copy(repository().join(file), dir.path(file)).unwrap();
    }
    dir
}

/// Plants a file at a place, sees that make refuses it by its name as it is `shown` and that nothing runs, and takes it
/// away.
fn plant(dir: &Workdir, place: &str, shown: &str, arguments: &[&str]) {
    for name in HOSTILE {
        let file = dir.path(&place.replace('@', name));
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, "").unwrap();
        let output = make_in(&dir.path("."), arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{file:?}: {said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{file:?}: {said}");
        let escaped = name.replace(' ', "\\ ").replace('\n', "\\n").replace('\t', "\\t");
        let escaped = escaped.replace('\u{e9}', "\\303\\251").replace('\u{1b}', "\\033");
        assert!(
            said.contains(&format!(" {}: the name", shown.replace('@', &escaped))),
            "{file:?}: {said}"
        );
        assert!(said.contains("has letters, digits, - . _ alone"), "{file:?}: {said}");
        let ran = ["ran", "mine/ran"].iter().any(|ran| dir.path(ran).exists());
        assert!(!ran && output.stdout.is_empty(), "{file:?}");
        fs::remove_file(&file).unwrap();
        // the folder of a hostile name is gone, too, if it was made here
        let _ = fs::remove_dir(file.parent().unwrap());
    }
}

/// In the checkout, and in a folder elsewhere by its own Makefile.
#[test]
fn names_of_files_run_nothing_and_are_told() {
    let dir = rules();
    let place = "pipelines/@/model.toml";
    plant(&dir, place, place, &["help"]);
    fs::create_dir(dir.path("mine")).unwrap();
    for file in ["model", "cad2fem", "tags", "sim", "mold"] {
        dir.write(&format!("mine/{file}.toml"), "");
    }
    let folder = dir.path("pipelines/folder.mk").display().to_string();
    dir.write("mine/Makefile", &format!("BIN := bin\ninclude {folder}\n"));
    let arguments = ["-C", "mine", "--no-print-directory"];
    assert!(make_in(&dir.path("."), &arguments).status.success());
    plant(&dir, "mine/sim.@.toml", "./sim.@.toml", &arguments);
}

/// Those that would put their results into a folder of others.
#[test]
fn names_of_scenes_are_their_own() {
    let dir = rules();
    fs::create_dir(dir.path("mine")).unwrap();
    for name in ["baseline", "mold", "pictures", "optimized", ".", "..", "", ".x"] {
        let file = format!("mine/sim.{name}.toml");
        dir.write(&file, "");
        let output = make_in(&dir.path("."), &["body", "DIR=mine"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(
            output.status.code() == Some(2)
                && said.contains(&format!("{file}: a scene beside others")),
            "{said}"
        );
        fs::remove_file(dir.path(&file)).unwrap();
    }
}

/// What `files` of chain.mk finds has been looked at; no other pattern brings names past it.
#[test]
fn patterns_go_through_one_check() {
    for file in RULES {
        let text = fs::read_to_string(repository().join(file)).unwrap();
        for rest in text.split("$(wildcard ").skip(1) {
            let line = rest.lines().next().unwrap();
            assert!(!line.contains('*'), "{file}: $(wildcard {line}: $(call files,...) finds it");
        }
    }
}
