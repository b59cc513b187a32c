//! An optimisation that is killed, or whose disk fills up, ends as one that is not.

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use mechanics::math::random::Random;
use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

pub const COMMAND: &str = "--threads 2 -q optimize design.toml -o out";

/// What must be the same: the bytes of design.msh, and history.jsonl without times.
pub fn results(dir: &Workdir) -> (Vec<u8>, Vec<Value>) {
    let history = dir.text("out/history.jsonl");
    let line = |line: &str| {
        let mut line: Value = serde_json::from_str(line).unwrap();
        for time in ["forward_s", "gradient_s", "time_s"] {
            assert!(line.as_object_mut().unwrap().remove(time).is_some());
        }
        line
    };
    let design = std::fs::read(dir.path("out/design.msh")).unwrap();
    (design, history.lines().map(line).collect())
}

/// A finished run that nothing disturbed.
pub fn undisturbed() -> Workdir {
    let dir = chamber::workdir();
    dir.solver(COMMAND).assert_good();
    dir
}

pub fn assert_same(dir: &Workdir, expected: &(Vec<u8>, Vec<Value>)) {
    let (design, history) = results(dir);
    assert_eq!(history.len(), expected.1.len(), "lines of history");
    for (line, expected) in history.iter().zip(&expected.1) {
        assert_eq!(line, expected);
    }
    assert!(design == expected.0, "design.msh differs");
}

/// Starts the program.
pub fn start(dir: &Workdir) -> Child {
    let mut command = dir.command(COMMAND);
    command.stderr(Stdio::null()).spawn().unwrap()
}

/// Starts the program and kills it (SIGKILL) as soon as `now` says so; false
/// when it was finished before.
fn killed(dir: &Workdir, mut now: impl FnMut() -> bool) -> bool {
    let mut child = start(dir);
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            return false;
        }
        if now() {
            child.kill().unwrap();
            return !child.wait().unwrap().success();
        }
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// Kills the program when its history has so many lines; false when it was finished before.
pub fn killed_when_at(dir: &Workdir, lines: usize) -> bool {
    let path = dir.path("out/history.jsonl");
    killed(dir, || std::fs::read_to_string(&path).is_ok_and(|text| text.lines().count() >= lines))
}

/// Kills the program whenever it has written a checkpoint, until it finishes,
/// and returns how often that was.
fn kill_after_every_checkpoint(dir: &Workdir) -> usize {
    let path = dir.path("out/checkpoint.json");
    let mut kills = 0;
    loop {
        let before = std::fs::read(&path).ok();
        if !killed(dir, || std::fs::read(&path).ok() != before) {
            return kills;
        }
        kills += 1;
        assert!(kills < 50, "no progress");
    }
}

#[test]
fn killed_after_every_checkpoint() {
    let expected = results(&undisturbed());
    let dir = chamber::workdir();
    let kills = kill_after_every_checkpoint(&dir);
    eprintln!("{kills} kills");
    // two levels begin, eight states are accepted; the last kill may come too late
    assert!(kills >= 8, "{kills}");
    assert_same(&dir, &expected);
}

/// A folder in which every level ends as soon as it may: not after its first step, which goes down the gradient.
fn stagnating() -> Workdir {
    let dir = chamber::workdir();
    let design = dir.text("design.toml").replace("first_step = 0.1", "stagnation = 0.9");
    dir.write("design.toml", &design);
    dir
}

#[test]
fn levels_that_stagnate_end_there_in_spite_of_kills() {
    let dir = stagnating();
    dir.solver(COMMAND).assert_good();
    let expected = results(&dir);
    assert_eq!(expected.1.len(), 6, "two steps per level");
    for _ in 0..3 {
        let dir = stagnating();
        assert!(kill_after_every_checkpoint(&dir) >= 4);
        assert_same(&dir, &expected);
    }
}

#[test]
fn killed_at_random_times() {
    let clock = Instant::now();
    let expected = results(&undisturbed());
    let whole = clock.elapsed().as_secs_f64();
    let mut random = Random::new(23);
    let (mut kills, mut folders) = (0, 0);
    // a run may be over before its kill; then another folder is next
    while kills < 6 {
        folders += 1;
        assert!(folders < 10, "only {kills} kills");
        let dir = chamber::workdir();
        loop {
            let delay = Duration::from_secs_f64(whole * 0.1 * (1.0 + random.uniform()));
            let clock = Instant::now();
            if kills > 20 || !killed(&dir, || clock.elapsed() > delay) {
                break;
            }
            kills += 1;
        }
        dir.solver(COMMAND).assert_good();
        assert_same(&dir, &expected);
    }
    eprintln!("{kills} kills in {folders} folders, of runs of {whole:.2} s");
}

/// How a level ended before the kill is still in the report.
#[test]
fn the_report_does_not_depend_on_kills() {
    let dir = stagnating();
    dir.solver(COMMAND).assert_good();
    let levels = dir.json("out/report.json")["levels"].clone();
    let ended = |level: &Value| level["ending"] == "converged";
    assert_eq!(
        levels.as_array().unwrap().iter().filter(|level| ended(level)).count(),
        2,
        "{levels}"
    );
    dir.solver(COMMAND).assert_good();
    assert_eq!(dir.json("out/report.json")["levels"], levels);
}

#[test]
fn finished_before() {
    let dir = undisturbed();
    let expected = results(&dir);
    dir.solver(COMMAND).assert_good();
    assert_same(&dir, &expected);
    dir.solver(&format!("{COMMAND} --restart")).assert_good();
    assert_same(&dir, &expected);
}

/// A handler of a library, as METIS has one while it orders, is never called.
#[test]
#[cfg(target_os = "linux")]
fn all_threads_block_the_signals_that_one_waits_for() {
    let dir = chamber::workdir();
    let mut child = start(&dir);
    let masks = || -> Vec<u64> {
        let threads = std::fs::read_dir(format!("/proc/{}/task", child.id())).unwrap();
        let mask = |status: String| {
            let value = |key: &str| status.lines().find_map(|line| line.strip_prefix(key));
            // The system shows no mask of the thread that waits, while it does.
            let computes = value("Name:")?.trim() != "signals";
            computes.then(|| u64::from_str_radix(value("SigBlk:")?.trim(), 16).ok())?
        };
        let status =
            |thread: std::fs::DirEntry| std::fs::read_to_string(thread.path().join("status"));
        threads.flatten().filter_map(|thread| mask(status(thread).ok()?)).collect()
    };
    let clock = Instant::now();
    // the first, which computes as well, and another one
    while masks().len() < 2 && clock.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let found = masks();
    child.kill().unwrap();
    child.wait().unwrap();
    let both = 1 << (2 - 1) | 1 << (15 - 1);
    assert!(found.len() >= 2 && found.iter().all(|mask| mask & both == both), "{found:x?}");
}

/// A limit on the size of files stands for a full disk [KiB].
#[test]
fn a_full_disk_and_then_room() {
    let expected = results(&undisturbed());
    let mut unwritten = Vec::new();
    for limit in [1, 19, 20] {
        let dir = chamber::workdir();
        let run = dir.solver_on_small_disk(limit, COMMAND);
        run.assert_refused(2, &["out/", "too large"]);
        let files = dir.files("out");
        assert!(!files.iter().any(|f| f.starts_with(".incomplete")), "{files:?}");
        assert!(!files.contains(&"report.json".to_owned()), "{files:?}");
        let file = run.stderr.split("out/").nth(1).and_then(|rest| rest.split(':').next());
        unwritten.push(file.unwrap_or_default().to_owned());
        dir.solver(COMMAND).assert_good();
        assert_same(&dir, &expected);
    }
    assert_eq!(unwritten, ["level-1.msh", "latest.msh", "result.vtu"]);
}

/// The history is the one file that grows in place.
#[test]
fn half_a_line_of_history_is_dropped() {
    let dir = unfinished();
    // the shape so far is there to be looked at, and gone once it is the design
    let latest = dir.path("out/latest.msh");
    assert!(!mesh::io::read_tets(&latest).unwrap().tags.facets.is_empty());
    let mut history = dir.text("out/history.jsonl");
    history.push_str("{\"level\":1,\"hand");
    dir.write("out/history.jsonl", &history);
    dir.solver(COMMAND).assert_good();
    assert_same(&dir, &results(&undisturbed()));
    assert!(!latest.exists());
}

/// A folder with an optimisation that was killed after two accepted states.
pub fn unfinished() -> Workdir {
    let dir = chamber::workdir();
    let history = dir.path("out/history.jsonl");
    let lines = || std::fs::read_to_string(&history).map_or(0, |text| text.lines().count());
    assert!(killed(&dir, || lines() > 1), "over before it was killed");
    dir
}

/// The model of the Gauss–Newton method lies in the checkpoint.
#[test]
fn a_killed_gauss_newton_run_ends_as_one_that_is_not() {
    let workdir = || {
        let dir = chamber::workdir();
        let method = "[optimizer]\nmethod = \"gauss-newton\"";
        dir.write("design.toml", &dir.text("design.toml").replace("[optimizer]", method));
        dir
    };
    let whole = workdir();
    whole.solver(COMMAND).assert_good();
    let dir = workdir();
    assert!(kill_after_every_checkpoint(&dir) > 2, "over before it was killed");
    assert_same(&dir, &results(&whole));
}

/// Bounds of probes and of the slope, what they cost, and the wall lie in the checkpoint.
#[test]
fn a_design_with_constraints_that_is_killed_ends_the_same() {
    let workdir = || {
        let dir = chamber::workdir();
        dir.write("p1.toml", &(dir.text("p1.toml") + chamber::PROBES));
        let kept = "[[constraint]]\nkind = \"wall\"\nname = \"thick\"\non = \"cavity\"\nagainst = [\"top\", \"skin\"]\n\
                    least = 5e-3\n\n[[constraint]]\nkind = \"probe\"\nname = \"rise\"\nprobe = \"top\"\nmost = 1e-3\n";
        let slope = "\n[[constraint]]\nkind = \"slope\"\nname = \"slope\"\nleast = 0.9\n\n";
        let design = dir.text("design.toml") + slope + kept;
        dir.write("design.toml", &design);
        dir
    };
    let whole = workdir();
    whole.solver(COMMAND).assert_good();
    let dir = workdir();
    assert!(kill_after_every_checkpoint(&dir) > 2, "over before it was killed");
    assert_same(&dir, &results(&whole));
}
