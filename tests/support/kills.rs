//! Programs that are killed, and then continue.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use mechanics::math::random::Random;
use serde_json::Value;

use crate::workdir::Workdir;

/// The history of a design without what tells times.
pub fn history_without_times(dir: &Workdir) -> Vec<Value> {
    let mut history = dir.lines("out/history.jsonl");
    for line in history.iter_mut().filter_map(Value::as_object_mut) {
        for time in ["forward_s", "gradient_s", "time_s"] {
            assert!(line.remove(time).is_some(), "{time}");
        }
    }
    history
}

/// Starts a program and kills it (SIGKILL) as soon as `now` says so; false when it was finished before.
pub fn killed(mut command: Command, mut now: impl FnMut() -> bool) -> bool {
    let mut child = command.stderr(Stdio::null()).spawn().expect("it starts");
    loop {
        if let Some(status) = child.try_wait().expect("it is ours") {
            assert!(status.success(), "{status}");
            return false;
        }
        if now() {
            child.kill().expect("it runs");
            return !child.wait().expect("it is ours").success();
        }
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// Kills a program at random moments, in folders in which it then runs to its end, and must end with the same.
pub fn kill_at_random_times(folder: fn() -> Workdir, command: &str, same: impl Fn(&Workdir)) {
    let clock = Instant::now();
    folder().solver(command).assert_good();
    let whole = clock.elapsed().as_secs_f64();
    let mut random = Random::new(23);
    let (mut kills, mut folders) = (0, 0);
    // a run may be over before its kill; then another folder is next
    while kills < 6 {
        folders += 1;
        assert!(folders < 10, "only {kills} kills");
        let dir = folder();
        loop {
            let delay = Duration::from_secs_f64(whole * 0.1 * (1.0 + random.uniform()));
            let clock = Instant::now();
            if kills > 20 || !killed(dir.command(command), || clock.elapsed() > delay) {
                break;
            }
            kills += 1;
        }
        dir.solver(command).assert_good();
        same(&dir);
    }
}

/// Kills the program whenever it has written a checkpoint, until it finishes, and returns how often that was.
pub fn kill_after_every_checkpoint(dir: &Workdir, command: &str) -> usize {
    let path = dir.path("out/checkpoint.json");
    let mut kills = 0;
    loop {
        let before = std::fs::read(&path).ok();
        if !killed(dir.command(command), || std::fs::read(&path).ok() != before) {
            return kills;
        }
        kills += 1;
        assert!(kills < 50, "no progress");
    }
}
