//! What is no file where a file is needed.

use std::os::unix::fs::symlink;
use std::process::Command;

use tests::chamber;
use tests::workdir::{Run, program};

#[test]
fn inputs_are_files_and_links_to_files() {
    let dir = chamber::workdir();
    symlink("body.msh", dir.path("link.msh")).unwrap();
    dir.run("tagger", "show link.msh").assert_good();
    assert!(Command::new("mkfifo").arg(dir.path("pipe.toml")).status().unwrap().success());
    for (name, arguments, words) in [
        ("tagger", "show /dev/zero", "it is a pipe or a device; a file is needed"),
        ("tagger", "show .", "it is a folder; a file is needed"),
        ("solver", "simulate pipe.toml -o out", "it is a pipe or a device; a file is needed"),
        ("cad2fem", "model pipe.toml -o out", "it is a pipe or a device; a file is needed"),
        (
            "fab",
            "plan body.msh --config pipe.toml -o out",
            "it is a pipe or a device; a file is needed",
        ),
    ] {
        dir.run(name, arguments).assert_refused(2, &[words]);
    }
    // the pipes that a shell makes
    let mut shell = Command::new("bash");
    shell.args(["-c", "\"$0\" show <(cat body.msh)"]).arg(program("tagger"));
    let run: Run = shell.current_dir(dir.path("")).output().unwrap().into();
    run.assert_good();
}
