//! What others put into folders that a program reads or runs from: links, pipes, checkouts.

use std::fs::{Permissions, copy, create_dir_all, set_permissions, write};
use std::io::ErrorKind;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::Command;

use tests::chamber;
use tests::workdir::{Run, Workdir, program};

const MODEL: &str = "unit = \"mm\"\ngrid = 3\n\
    [[solid]]\nname = \"box\"\nshape.box = { center = [0, 0, 0], size = [16, 16, 16] }\n\
    [[region]]\nname = \"skin\"\nrest = true\n";

fn run(dir: &Workdir, name: &str, arguments: &str) -> Run {
    dir.command_of(name, arguments).output().unwrap().into()
}

/// Runs a program that was copied: a child of another test may hold it open for a moment.
fn copied(command: &mut Command) -> Run {
    loop {
        match command.output() {
            Err(error) if error.kind() == ErrorKind::ExecutableFileBusy => std::thread::yield_now(),
            output => return output.unwrap().into(),
        }
    }
}

fn pipe(dir: &Workdir, name: &str) {
    assert!(Command::new("mkfifo").arg(dir.path(name)).status().unwrap().success());
}

#[test]
fn the_file_that_is_locked_may_be_no_link() {
    let dir = Workdir::new();
    dir.write("model.toml", MODEL);
    dir.write("victim", "precious");
    create_dir_all(dir.path("out")).unwrap();
    symlink("../victim", dir.path("out/.lock")).unwrap();
    run(&dir, "cad2fem", "model model.toml -o out").assert_refused(2, &["out/.lock", "a link"]);
    assert_eq!(dir.text("victim"), "precious");
}

#[test]
fn inputs_are_files_and_links_to_files() {
    let dir = chamber::workdir();
    symlink("body.msh", dir.path("link.msh")).unwrap();
    run(&dir, "tagger", "show link.msh").assert_good();
    dir.write(
        "tags.toml",
        "[[tag]]\nname = \"all\"\nbox = { min = [-1, -1, -1], max = [1, 1, 1] }\n",
    );
    pipe(&dir, "pipe.msh");
    pipe(&dir, "pipe.toml");
    symlink("/dev/zero", dir.path("device.msh")).unwrap();
    symlink("pipe.msh", dir.path("there.msh")).unwrap();
    for (name, arguments, words) in [
        ("tagger", "show pipe.msh", "it is a pipe; a file is needed"),
        ("tagger", "show there.msh", "it is a pipe; a file is needed"),
        ("tagger", "show device.msh", "it is a device; a file is needed"),
        ("tagger", "show /dev/zero", "it is a device; a file is needed"),
        ("tagger", "show .", "it is a folder; a file is needed"),
        ("solver", "simulate pipe.toml -o out", "it is a pipe; a file is needed"),
        ("cad2fem", "model pipe.toml -o out", "it is a pipe; a file is needed"),
        ("fab", "plan pipe.msh --config pipe.toml -o out", "it is a pipe; a file is needed"),
        ("tagger", "tag body.msh --config tags.toml -o pipe.msh", "no file that can be replaced"),
    ] {
        run(&dir, name, arguments).assert_refused(2, &[words]);
    }
    // the pipes that a shell makes
    let mut shell = Command::new("bash");
    shell.args(["-c", "\"$0\" show <(cat body.msh)"]).arg(program("tagger"));
    let run: Run = shell.current_dir(dir.path("")).output().unwrap().into();
    run.assert_good();
}

#[test]
fn a_page_shows_nothing_that_a_link_leads_to() {
    let dir = chamber::workdir();
    dir.write("secret.svg", "<svg xmlns='http://www.w3.org/2000/svg'><title>secret</title></svg>");
    create_dir_all(dir.path("elsewhere")).unwrap();
    copy(dir.path("secret.svg"), dir.path("elsewhere/y.svg")).unwrap();
    dir.solver("simulate sim.toml -o all/run").assert_good();
    create_dir_all(dir.path("all/pictures")).unwrap();
    symlink("../../secret.svg", dir.path("all/pictures/x.svg")).unwrap();
    pipe(&dir, "all/pictures/z.png");
    let page = run(&dir, "cad2fem", "report all -o page.html");
    page.assert_good();
    for left_out in ["all/pictures/x.svg: left out", "all/pictures/z.png: left out"] {
        assert!(page.stderr.contains(left_out), "{}", page.stderr);
    }
    std::fs::remove_dir_all(dir.path("all/pictures")).unwrap();
    symlink("../elsewhere", dir.path("all/pictures")).unwrap();
    run(&dir, "cad2fem", "report all -o folder.html").assert_good();
    // the same picture where it is no link is shown
    std::fs::remove_file(dir.path("all/pictures")).unwrap();
    create_dir_all(dir.path("all/pictures")).unwrap();
    copy(dir.path("secret.svg"), dir.path("all/pictures/x.svg")).unwrap();
    run(&dir, "cad2fem", "report all -o shown.html").assert_good();
    let pictures = |page: &str| dir.text(page).matches("data:image/svg+xml").count();
    assert!(pictures("shown.html") > pictures("page.html"));
    assert_eq!(pictures("folder.html"), pictures("page.html"));
}

/// The programs of the archive in a folder above which others may write.
#[test]
fn python_of_a_planted_checkout_is_not_run() {
    let dir = Workdir::new();
    let tetrahedron = "solid t\n\
        facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0.01 0\nvertex 0.01 0 0\nendloop\nendfacet\n\
        facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0.01 0 0\nvertex 0 0 0.01\nendloop\nendfacet\n\
        facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 0.01\nvertex 0 0.01 0\nendloop\nendfacet\n\
        facet normal 0 0 0\nouter loop\nvertex 0.01 0 0\nvertex 0 0.01 0\nvertex 0 0 0.01\nendloop\nendfacet\n\
        endsolid t\n";
    dir.write("t.stl", tetrahedron);
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
        command.args(["tetmesh", "t.stl", "--no-cache", "-o", "v.msh"]).current_dir(dir.path(""));
        let run = copied(command.env_remove("PUFFER_PYTHON"));
        set_permissions(dir.path(of), Permissions::from_mode(0o755)).unwrap();
        run
    };
    for (mode, of) in [
        (0o1777, "shared"),
        (0o777, "shared"),
        (0o777, "shared/.venv"),
        (0o1777, "shared/.venv/bin"),
        (0o777, "shared/.venv/bin/python"),
    ] {
        let refused = mesh(mode, of);
        refused.assert_refused(2, &["others than you", "PUFFER_PYTHON"]);
        assert!(!ran.exists(), "{of}");
    }
    // one's own is run
    mesh(0o755, "shared");
    assert!(ran.exists());
}

/// The programs of an archive, and of a package of Python, beside which others may write.
#[test]
fn planted_rules_and_pythons_are_not_used() {
    let dir = Workdir::new();
    let packages = "env/lib/python3.11/site-packages";
    for folder in ["env/bin", &format!("{packages}/softpuffer/bin")] {
        create_dir_all(dir.path(folder)).unwrap();
    }
    let share = format!("{packages}/softpuffer/share/puffer");
    create_dir_all(dir.path(&share)).unwrap();
    for file in ["folder.mk", "chain.mk"] {
        dir.write(&format!("{share}/{file}"), "");
    }
    let cad2fem = dir.path(&format!("{packages}/softpuffer/bin/cad2fem"));
    copy(program("cad2fem"), &cad2fem).unwrap();
    let (python, ran) = (dir.path("env/bin/python3.11"), dir.path("ran"));
    write(&python, format!("#!/bin/sh\ntouch {}\n", ran.display())).unwrap();
    set_permissions(&python, Permissions::from_mode(0o755)).unwrap();
    let run = |verb: &str| -> Run {
        let mut command = Command::new(&cad2fem);
        copied(command.arg(verb).current_dir(dir.path("")).env_remove("PUFFER_PYTHON"))
    };
    for (place, verb) in [
        (share.as_str(), "rules"),
        (&format!("{share}/folder.mk"), "rules"),
        (&format!("{share}/chain.mk"), "rules"),
        ("env/bin", "doctor"),
        ("env/bin/python3.11", "doctor"),
    ] {
        let before = std::fs::metadata(dir.path(place)).unwrap().permissions();
        set_permissions(dir.path(place), Permissions::from_mode(before.mode() | 0o002)).unwrap();
        let found = run(verb);
        assert!(found.stderr.contains("others than you"), "{place}: {}", found.stderr);
        assert!(found.code != Some(0) && !ran.exists(), "{place}");
        set_permissions(dir.path(place), before).unwrap();
    }
    // one's own are used
    assert!(run("rules").stdout.ends_with("softpuffer/share/puffer/folder.mk\n"));
    run("doctor");
    assert!(ran.exists());
}
