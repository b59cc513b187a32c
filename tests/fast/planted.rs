//! Links, pipes, devices and folders in place of files.

use std::os::unix::fs::symlink;
use std::process::Command;

use tests::chamber;
use tests::workdir::{Run, Workdir, program};

fn run(dir: &Workdir, name: &str, arguments: &str) -> Run {
    dir.command_of(name, arguments).output().unwrap().into()
}

fn pipe(dir: &Workdir, name: &str) {
    assert!(Command::new("mkfifo").arg(dir.path(name)).status().unwrap().success());
}

#[test]
fn inputs_are_files_and_links_to_files() {
    let dir = chamber::workdir();
    symlink("body.msh", dir.path("link.msh")).unwrap();
    run(&dir, "tagger", "show link.msh").assert_good();
    pipe(&dir, "pipe.msh");
    pipe(&dir, "pipe.toml");
    symlink("/dev/zero", dir.path("device.msh")).unwrap();
    symlink("pipe.msh", dir.path("there.msh")).unwrap();
    for (name, arguments, words) in [
        ("tagger", "show pipe.msh", "it is a pipe or a device; a file is needed"),
        ("tagger", "show there.msh", "it is a pipe or a device; a file is needed"),
        ("tagger", "show device.msh", "it is a pipe or a device; a file is needed"),
        ("tagger", "show /dev/zero", "it is a pipe or a device; a file is needed"),
        ("tagger", "show .", "it is a folder; a file is needed"),
        ("solver", "simulate pipe.toml -o out", "it is a pipe or a device; a file is needed"),
        ("cad2fem", "model pipe.toml -o out", "it is a pipe or a device; a file is needed"),
        (
            "fab",
            "plan pipe.msh --config pipe.toml -o out",
            "it is a pipe or a device; a file is needed",
        ),
    ] {
        run(&dir, name, arguments).assert_refused(2, &[words]);
    }
    // the pipes that a shell makes
    let mut shell = Command::new("bash");
    shell.args(["-c", "\"$0\" show <(cat body.msh)"]).arg(program("tagger"));
    let run: Run = shell.current_dir(dir.path("")).output().unwrap().into();
    run.assert_good();
}
