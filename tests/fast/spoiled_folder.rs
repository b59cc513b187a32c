//! `solver optimize` in a folder that holds something else, or not all.

use std::time::Duration;

use tests::chamber;
use tests::workdir::Workdir;

use crate::resume::{COMMAND, assert_same, results, start, undisturbed, unfinished};

/// Changes one byte or number of every input in turn.
fn with_other_inputs(dir: &Workdir, mut then: impl FnMut(&str)) {
    for (file, from, to) in [
        ("design.toml", "weight = 1e10", "weight = 2e10"),
        ("p1.toml", "8e3", "7e3"),
        ("body.msh", "\n1 0.0 0.0 0.0\n", "\n1 0.0 0.0 1e-9\n"),
    ] {
        let sound = dir.text(file);
        assert!(sound.contains(from), "{file}");
        dir.write(file, &sound.replacen(from, to, 1));
        then(file);
        dir.write(file, &sound);
    }
    let mut target = std::fs::read(dir.path("target.stl")).unwrap();
    target[0] ^= 1; // the comment at the start
    std::fs::write(dir.path("target.stl"), target).unwrap();
    then("target.stl");
}

#[test]
fn unfinished_work_on_other_inputs_is_not_thrown_away() {
    let dir = unfinished();
    let words = ["out/checkpoint.json", "another problem", "--restart"];
    with_other_inputs(&dir, |_| dir.solver(COMMAND).assert_refused(2, &words));
    dir.solver(&format!("{COMMAND} --restart")).assert_good();
    // the comment of the target is all that differs
    assert_same(&dir, &results(&undisturbed()));
}

#[test]
fn a_finished_folder_is_used_again_for_other_inputs() {
    let dir = undisturbed();
    let inputs = |dir: &Workdir| dir.json("out/checkpoint.json")["content"]["inputs"].clone();
    let mut before = inputs(&dir);
    with_other_inputs(&dir, |file| {
        let run = dir.solver(COMMAND);
        run.assert_good();
        assert!(run.stderr.contains("the finished design there is replaced"), "{}", run.stderr);
        let now = inputs(&dir);
        assert_ne!(std::mem::replace(&mut before, now.clone()), now, "{file}");
        assert_eq!(results(&dir).1.len(), 8, "{file}");
    });
}

/// A checkpoint that is none, one whose numbers do not belong to the level, a history that is too short, and one digit of
/// each file from which an interrupted design continues.
#[test]
fn altered_files_are_never_used() {
    let dir = undisturbed();
    let checkpoint = dir.text("out/checkpoint.json");
    let history = dir.text("out/history.jsonl");
    let refused = |name: &str, text: &[u8], words: &[&str]| {
        let path = dir.path(&format!("out/{name}"));
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, text).unwrap();
        dir.solver(COMMAND).assert_refused(2, &[&[name], words].concat());
        std::fs::write(&path, whole).unwrap();
    };
    for spoiled in ["", "{", &checkpoint[..checkpoint.len() / 2], "[1, 2]", "{\"inputs\": 3}"] {
        refused("checkpoint.json", spoiled.as_bytes(), &["column"]);
    }
    refused("level-2.msh", b"", &[]);
    let first = history.lines().next().unwrap().to_owned() + "\n";
    for lines in ["", &first] {
        refused("history.jsonl", lines.as_bytes(), &["8"]);
    }
    let is_run = |name: &String| name.starts_with("run-");
    let run = dir.files("out").into_iter().find(is_run).unwrap();
    for name in ["checkpoint.json", "history.jsonl", "level-1.msh", "level-2.msh", &run] {
        let mut altered = std::fs::read(dir.path(&format!("out/{name}"))).unwrap();
        let digit = altered.iter().rposition(u8::is_ascii_digit).unwrap();
        altered[digit] = if altered[digit] == b'3' { b'4' } else { b'3' };
        refused(name, &altered, &["--restart"]);
    }
    dir.solver(COMMAND).assert_good();
}

/// History without a checkpoint does not show where to continue.
#[test]
fn without_a_checkpoint_all_begins_anew() {
    let dir = undisturbed();
    let expected = results(&dir);
    std::fs::remove_file(dir.path("out/checkpoint.json")).unwrap();
    dir.solver(COMMAND).assert_good();
    assert_same(&dir, &expected);
}

#[test]
fn a_second_writer_is_refused() {
    let dir = chamber::workdir();
    let mut first = start(&dir);
    while !dir.path("out/checkpoint.json").exists() {
        assert!(first.try_wait().unwrap().is_none(), "over before the second began");
        std::thread::sleep(Duration::from_millis(1));
    }
    dir.solver(COMMAND).assert_refused(2, &["out: ", "another process writes to this folder"]);
    assert!(first.wait().unwrap().success());
    assert_same(&dir, &results(&undisturbed()));
}
