//! What is no file where a file is needed, and a checkout of others.

use std::fs::{Permissions, copy, create_dir_all, set_permissions, write};
use std::io::ErrorKind;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::Command;

use tests::chamber;
use tests::workdir::{Run, Workdir, program};

/// Runs a program that was copied: a child of another test may hold it open for a moment.
fn copied(command: &mut Command) -> Run {
    loop {
        match command.output() {
            Err(error) if error.kind() == ErrorKind::ExecutableFileBusy => std::thread::yield_now(),
            output => return output.unwrap().into(),
        }
    }
}

#[test]
fn inputs_are_files_and_links_to_files() {
    let dir = chamber::workdir();
    symlink("body.msh", dir.path("link.msh")).unwrap();
    dir.run("tagger", "show link.msh").assert_good();
    assert!(Command::new("mkfifo").arg(dir.path("pipe.toml")).status().unwrap().success());
    for (name, arguments, words) in [
        ("tagger", "show /dev/zero", "it is a device; a file is needed"),
        ("tagger", "show .", "it is a folder; a file is needed"),
        ("solver", "simulate pipe.toml -o out", "it is a pipe; a file is needed"),
        ("cad2fem", "model pipe.toml -o out", "it is a pipe; a file is needed"),
        ("fab", "plan body.msh --config pipe.toml -o out", "it is a pipe; a file is needed"),
    ] {
        dir.run(name, arguments).assert_refused(2, &[words]);
    }
    // the pipes that a shell makes
    let mut shell = Command::new("bash");
    shell.args(["-c", "\"$0\" show <(cat body.msh)"]).arg(program("tagger"));
    let run: Run = shell.current_dir(dir.path("")).output().unwrap().into();
    run.assert_good();
}

/// The programs of the archive in a folder above which others may write.
#[test]
fn python_of_a_planted_checkout_is_not_run() {
    let dir = Workdir::new();
    dir.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    for folder in ["shared/alice/bin", "shared/cad2fem", "shared/.venv/bin", "shared/alice/lib"] {
        create_dir_all(dir.path(folder)).unwrap();
    }
    copy(program("cad2fem"), dir.path("shared/alice/bin/cad2fem")).unwrap();
    write(dir.path("shared/cad2fem/Cargo.toml"), "").unwrap();
    let python = dir.path("shared/.venv/bin/python");
    let ran = dir.path("ran");
    write(&python, format!("#!/bin/sh\ntouch {}\n", ran.display())).unwrap();
    set_permissions(&python, Permissions::from_mode(0o755)).unwrap();
    let mesh = |mode: u32, of: &str| -> Run {
        set_permissions(dir.path(of), Permissions::from_mode(mode)).unwrap();
        let mut command = Command::new(dir.path("shared/alice/bin/cad2fem"));
        command.args(["tetmesh", "t.obj", "--no-cache", "-o", "v.msh"]).current_dir(dir.path(""));
        let run = copied(command.env_remove("PUFFER_PYTHON"));
        set_permissions(dir.path(of), Permissions::from_mode(0o755)).unwrap();
        run
    };
    for of in ["shared", "shared/.venv", "shared/.venv/bin/python"] {
        let refused = mesh(0o777, of);
        refused.assert_refused(2, &["others than you", "PUFFER_PYTHON"]);
        assert!(!ran.exists(), "{of}");
    }
    // one's own is run
    mesh(0o755, "shared");
    assert!(ran.exists());
}
