//! A simulation through time with contact that is killed ends as one that is not.

use std::process::{Command, Stdio};
use std::time::Duration;

use mesh::io::write_surface;
use tests::fall::{STEPS, workdir};
use tests::kills::{kill_at_random_times, killed};
use tests::workdir::Workdir;

use crate::{mullins, relaxation};

pub const COMMAND: &str = "--threads 2 -q simulate sim.toml -o out";

/// What must be the same, byte for byte.
fn results(dir: &Workdir) -> (Vec<u8>, String, u64) {
    let factor = dir.json("out/report.json")["factor_entries"].as_u64().unwrap();
    (std::fs::read(dir.path("out/displacement.npy")).unwrap(), dir.text("out/steps.jsonl"), factor)
}

fn assert_same(dir: &Workdir, (displacement, lines, factor): &(Vec<u8>, String, u64)) {
    let found = results(dir);
    for (i, (line, expected)) in found.1.lines().zip(lines.lines()).enumerate() {
        assert_eq!(line, expected, "step {}", i + 1);
    }
    assert_eq!(found.1.lines().count(), STEPS);
    assert!(found.0 == *displacement, "displacement.npy differs");
    assert_eq!(found.2, *factor, "entries of the factor");
    let files = dir.files("out");
    assert!(!files.contains(&"checkpoint.json".to_owned()), "{files:?}");
    assert_eq!(files.iter().filter(|f| f.starts_with("step_")).count(), STEPS, "{files:?}");
}

#[test]
fn killed_at_random_times() {
    let undisturbed = workdir();
    undisturbed.solver(COMMAND).assert_good();
    let expected = results(&undisturbed);
    // without contact it would prove little
    let last = undisturbed.lines("out/steps.jsonl").pop().unwrap();
    assert!(!last["collisions"]["friction"].as_array().unwrap().is_empty(), "{last}");
    assert!(last["work_of_loads"].as_f64().unwrap() > 0.0, "{last}");
    kill_at_random_times(workdir, COMMAND, |dir| assert_same(dir, &expected));
}

/// What softening and relaxation remember lies in the checkpoint.
#[test]
#[ignore = "some seconds: runs in make test-all"]
fn a_killed_run_remembers_its_past() {
    let rises: Vec<f64> = (0..400).map(|i| 4e-3 * (1.0 - (0.05 * f64::from(i)).cos())).collect();
    let softened = || mullins::moved(&mullins::table(mullins::SOFTENING), &rises);
    let relaxed = || relaxation::bar(&relaxation::table(relaxation::BRANCH), 400);
    let command = "--threads 2 -q simulate p1.toml -o out --final-only";
    for folder in [&softened as &dyn Fn() -> Workdir, &relaxed] {
        let whole = folder();
        whole.solver(command).assert_good();
        let dir = folder();
        let checkpoint = dir.path("out/checkpoint.json");
        assert!(killed(dir.command(command), || checkpoint.exists()), "over before it was killed");
        dir.solver(command).assert_good();
        assert_eq!(dir.text("out/steps.jsonl"), whole.text("out/steps.jsonl"));
    }
}

/// A folder with a run that was killed after some steps.
pub fn unfinished() -> Workdir {
    let dir = workdir();
    let checkpoint = dir.path("out/checkpoint.json");
    assert!(killed(dir.command(COMMAND), || checkpoint.exists()), "over before it was killed");
    dir
}

#[test]
fn signals_end_it_in_order() {
    let undisturbed = workdir();
    undisturbed.solver(COMMAND).assert_good();
    let expected = results(&undisturbed);
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let dir = workdir();
        let child = dir.command(COMMAND).stderr(Stdio::piped()).spawn().unwrap();
        while !dir.path("out/checkpoint.json").exists() {
            std::thread::sleep(Duration::from_micros(300));
        }
        let pid = child.id().to_string();
        let sent = Command::new("kill").args(["-s", signal, &pid]).status().unwrap();
        let ended = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert!(sent.success(), "over before the signal: {said}");
        assert_eq!(ended.status.code(), Some(code), "{said}");
        assert!(
            said.contains(&format!("interrupted by SIG{signal}; the same command continues")),
            "{said}"
        );
        let files = dir.files("out");
        assert!(!files.iter().any(|f| f.starts_with('.')), "{files:?}");
        dir.solver(COMMAND).assert_good();
        assert_same(&dir, &expected);
    }
}

#[test]
fn an_unfinished_run_of_another_scene() {
    let dir = unfinished();
    let sound = dir.text("sim.toml");
    dir.write("sim.toml", &sound.replace("friction = 0.4", "friction = 0.5"));
    let run = dir.solver(COMMAND);
    run.assert_refused(2, &["checkpoint.json", "another scene", "steps", "--restart"]);
    assert!(dir.path("out/checkpoint.json").exists());
    // the floor counts, too
    dir.write("sim.toml", &sound);
    let floor = std::fs::read(dir.path("floor.stl")).unwrap();
    let mut moved = mesh::io::read_surface(&dir.path("floor.stl")).unwrap();
    moved.vertices.iter_mut().for_each(|v| v.z -= 1e-5);
    write_surface(&dir.path("floor.stl"), &moved).unwrap();
    dir.solver(COMMAND).assert_refused(2, &["checkpoint.json", "--restart"]);
    std::fs::write(dir.path("floor.stl"), floor).unwrap();
    let again = workdir();
    again.solver(COMMAND).assert_good();
    dir.solver(&format!("{COMMAND} --restart")).assert_good();
    assert_same(&dir, &results(&again));
}

#[test]
fn a_checkpoint_that_is_none() {
    let dir = unfinished();
    let (text, steps) = (dir.text("out/checkpoint.json"), dir.text("out/steps.jsonl"));
    dir.write("out/checkpoint.json", &text[..text.len() / 2]);
    dir.solver(COMMAND).assert_refused(2, &["checkpoint.json: broken checkpoint", "--restart"]);
    dir.write("out/checkpoint.json", &text);
    dir.write("out/steps.jsonl", "");
    dir.solver(COMMAND).assert_refused(2, &["steps.jsonl: not the", "--restart"]);
    dir.write("out/steps.jsonl", &steps);
    let picture = std::fs::read(dir.path("out/step_000.vtu")).unwrap();
    dir.write("out/step_000.vtu", "");
    dir.solver(COMMAND).assert_refused(2, &["step_000.vtu: it has the SHA-256", "--restart"]);
    std::fs::write(dir.path("out/step_000.vtu"), picture).unwrap();
    // one digit of a displacement
    let digit = text.rfind("\"work\"").unwrap() - 20;
    let digit = digit + text[digit..].find(|c: char| c.is_ascii_digit()).unwrap();
    let other = if &text[digit..=digit] == "1" { "2" } else { "1" };
    dir.write("out/checkpoint.json", &format!("{}{other}{}", &text[..digit], &text[digit + 1..]));
    dir.solver(COMMAND).assert_refused(2, &["checkpoint.json: broken checkpoint", "altered"]);
    dir.solver(&format!("{COMMAND} --restart")).assert_good();
}
