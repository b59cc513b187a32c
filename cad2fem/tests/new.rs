//! Folders to begin with, and what a machine lacks.

use std::fs;

use cad2fem::template::TEMPLATES;

use crate::support::Workdir;

#[test]
fn every_template_is_written_with_its_results_beside_it() {
    let dir = Workdir::new();
    for template in TEMPLATES {
        let run = dir.run(&format!("new {} --like {}", template.name, template.name));
        run.succeeds();
        assert!(run.stdout.contains(&format!("make -C {}\n", template.name)), "{}", run.stdout);
        for file in template.files.iter().map(|(file, _)| *file).chain(["README.md", "Makefile"]) {
            let text =
                fs::read_to_string(dir.path(template.name).join(file)).expect("a file of the test");
            assert!(!text.contains("../../build"), "{}/{file}: {text}", template.name);
            assert!(!text.is_empty(), "{}/{file}", template.name);
        }
    }
    // others take longer: tests/slow makes them
    dir.run("model blank/model.toml -o blank/build/model").succeeds();
    let scene = fs::read_to_string(dir.path("blank/sim.toml")).expect("a file of the test");
    assert!(scene.contains("mesh = \"build/tagged.msh\""), "{scene}");
}

#[test]
fn a_body_in_pipelines_has_its_results_in_build() {
    let dir = Workdir::new();
    fs::create_dir(dir.path("pipelines")).expect("a file of the test");
    dir.write("pipelines/rules.mk", "");
    let run = dir.run("new pipelines/mine");
    run.succeeds();
    assert!(run.stdout.contains("make mine\n"), "{}", run.stdout);
    let scene =
        fs::read_to_string(dir.path("pipelines/mine/sim.toml")).expect("a file of the test");
    assert!(scene.contains("mesh = \"../../build/mine/tagged.msh\""), "{scene}");
    assert!(!dir.path("pipelines/mine/Makefile").exists());
}

#[test]
fn nothing_is_overwritten_and_names_are_checked() {
    let dir = Workdir::new();
    dir.write("there", "");
    dir.run("new there").fails(2, "there: is there already");
    fs::create_dir(dir.path("pipelines")).expect("a file of the test");
    dir.write("pipelines/rules.mk", "");
    dir.run("new pipelines/mine --like gripper").fails(2, "rules of its own");
    assert!(!dir.path("pipelines/mine").exists());
    for name in
        ["two words", "a$b", "a;b", "a#b", "a:b", "a'b", "a\"b", "a\\b", "a\nb", "-a", "a%b", ""]
    {
        dir.run_words(&["new", "--", name]).fails(2, "");
        assert!(!dir.path(name).is_dir() || name.is_empty(), "{name}");
    }
    dir.run_words(&["new", "two words"]).fails(2, "letters, digits, - and _");
    dir.run_words(&["new", "some folders/mine"]).fails(2, "take the ' ' in it for their own");
    assert!(!dir.path("some folders").exists());
    let run = dir.run("new mine --like fingr");
    run.fails(2, "there is no fingr; did you mean `finger`?");
    run.fails(2, "blank        a finger of four cells");
    assert!(!dir.path("mine").exists());
}

#[test]
fn what_is_missing_is_named_with_its_remedy() {
    let dir = Workdir::new();
    // a Python without packages
    let python = dir.program("python", "echo 'ModuleNotFoundError: gmsh' >&2; exit 1");
    let run = dir.run_with("PUFFER_PYTHON", &python, "doctor");
    run.fails(1, "are missing");
    for line in [
        "ok       Python",
        "missing  fTetWild       for cad2fem tetmesh",
        "has no package wildmeshing or pytetwild; pip install softpuffer, in a checkout `make setup`",
        "missing  gmsh",
    ] {
        assert!(run.stdout.contains(line), "{line}: {}", run.stdout);
    }
    // one whose gmsh lacks a library
    let script = "case \"$*\" in *metadata*) echo $4 4.15;; *) echo 'OSError: libGLU.so.1: cannot open' >&2; exit 1;; esac";
    let python = dir.program("python", script);
    let run = dir.run_with("PUFFER_PYTHON", &python, "doctor");
    run.fails(1, "are missing");
    assert!(run.stdout.contains("libGLU.so.1"), "{}", run.stdout);
    assert!(run.stdout.contains("apt install libglu1-mesa"), "{}", run.stdout);
    // an empty variable is as none
    let run = dir.run_with("PUFFER_PYTHON", "", "doctor");
    assert!(!run.stdout.contains("not a file"), "{}", run.stdout);
}
