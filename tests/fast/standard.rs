//! Standard input and output in place of files: `stl:-`.

use std::io::{ErrorKind, Write};
use std::process::{Command, Output, Stdio};

use tests::chamber;
use tests::workdir::{Workdir, program};

/// A program in a folder, with something on its standard input.
fn fed(dir: &Workdir, name: &str, arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(program(name))
        .args(arguments)
        .current_dir(dir.path(""))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    match child.stdin.take().unwrap().write_all(input) {
        // one that refuses its arguments may end before it has read
        Err(error) if error.kind() == ErrorKind::BrokenPipe => {}
        written => written.unwrap(),
    }
    child.wait_with_output().unwrap()
}

#[test]
fn programs_are_joined_by_pipes() {
    let dir = chamber::workdir();
    let surface = std::fs::read(dir.path("target.stl")).unwrap();
    let said = |output: &Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let good = |output: Output| {
        assert!(output.status.success(), "{}", said(&output));
        output.stdout
    };
    let from_file = fed(&dir, "cad2fem", &["info", "target.stl"], b"");
    let from_pipe = good(fed(&dir, "cad2fem", &["info", "stl:-"], &surface));
    let text = String::from_utf8(from_pipe).unwrap().replace("stl:-", "target.stl");
    assert_eq!(text, String::from_utf8(good(from_file)).unwrap());

    dir.solver("simulate p1.toml -o out").assert_good();
    let steps = std::fs::read(dir.path("out/steps.jsonl")).unwrap();
    let plot = ["plot", "jsonl:-", "--x", "t", "--y", "chambers.cavity.volume", "-o", "svg:-"];
    let svg = good(fed(&dir, "solver", &plot, &steps));
    assert!(svg.starts_with(b"<svg") || svg.starts_with(b"<?xml"), "{:?}", &svg[..60]);
    let files = dir.files("");
    assert!(!files.iter().any(|f| f.contains(":-")), "{files:?}");

    let result = std::fs::read(dir.path("out/result.vtu")).unwrap();
    let picture = ["picture", "vtu:-", "--color", "displacement", "-o", "png:-"];
    assert!(good(fed(&dir, "cad2fem", &picture, &result)).starts_with(b"\x89PNG"));

    let nameless = fed(&dir, "cad2fem", &["info", "-"], &surface);
    assert_eq!(nameless.status.code(), Some(2));
    assert!(said(&nameless).contains("need a format, as in stl:-"), "{}", said(&nameless));
}
