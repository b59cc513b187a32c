//! An optimisation that is killed, or whose disk fills up, ends as one that is not.

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tests::chamber;
use tests::kills::{
    history_without_times, kill_after_every_checkpoint, kill_at_random_times, killed,
};
use tests::workdir::Workdir;

use crate::scenarios;

pub const COMMAND: &str = "--threads 2 -q optimize design.toml -o out";

/// What must be the same: the bytes of design.msh, and history.jsonl without times.
pub fn results(dir: &Workdir) -> (Vec<u8>, Vec<Value>) {
    (std::fs::read(dir.path("out/design.msh")).unwrap(), history_without_times(dir))
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

/// The chamber with a change of its design.
fn changed(old: &str, new: &str) -> Workdir {
    let dir = chamber::workdir();
    let sound = dir.text("design.toml");
    assert!(sound.contains(old), "{old}");
    dir.write("design.toml", &sound.replacen(old, new, 1));
    dir
}

/// Bounds of probes and of the slope, what they cost, and the wall lie in the checkpoint.
fn constrained() -> Workdir {
    let kept = "[[constraint]]\nkind = \"wall\"\nname = \"thick\"\non = \"cavity\"\nagainst = [\"top\", \"skin\"]\n\
                least = 5e-3\n\n[[constraint]]\nkind = \"probe\"\nname = \"rise\"\nprobe = \"top\"\nmost = 1e-3\n\n\
                [[constraint]]\nkind = \"slope\"\nname = \"slope\"\nleast = 0.9\n\n[shape]";
    let dir = changed("[shape]", kept);
    dir.write("p1.toml", &(dir.text("p1.toml") + chamber::PROBES));
    dir
}

/// A weight that was found from a share at the start is that of the whole design.
fn shared() -> Workdir {
    let dir = scenarios::workdir("[robust]\ndeviations = 1\n");
    let shared = dir.text("design.toml").replacen("weight = 1e10", "share = 0.9", 1);
    dir.write("design.toml", &shared);
    dir
}

type Design = (&'static str, fn() -> Workdir, usize);

/// Designs by their names, with the least number of their checkpoints that are killed.
const DESIGNS: [Design; 5] = [
    // two levels begin, eight states are accepted; the last kill may come too late
    ("plain", chamber::workdir, 8),
    // every level ends as soon as it may: not after its first step, which goes down the gradient
    ("stagnating", || changed("first_step = 0.1", "stagnation = 0.9"), 4),
    // the model of the method lies in the checkpoint
    ("gauss-newton", || changed("[optimizer]", "[optimizer]\nmethod = \"gauss-newton\""), 3),
    ("constraints", constrained, 3),
    ("scenarios with a share", shared, 3),
];

#[test]
fn killed_after_every_checkpoint() {
    for (name, folder, least) in DESIGNS {
        let whole = folder();
        whole.solver(COMMAND).assert_good();
        let dir = folder();
        let kills = kill_after_every_checkpoint(&dir, COMMAND);
        assert!(kills >= least, "{name}: {kills} kills");
        assert_same(&dir, &results(&whole));
        // how a level ended before a kill is still in the report
        let levels = |dir: &Workdir| -> Vec<Value> {
            let report = dir.json("out/report.json");
            report["levels"].as_array().unwrap().iter().map(|l| l["ending"].clone()).collect()
        };
        assert_eq!(levels(&dir), levels(&whole), "{name}");
        if name == "stagnating" {
            assert_eq!(levels(&dir), ["converged", "converged"]);
        }
    }
}

#[test]
fn killed_at_random_times() {
    let expected = results(&undisturbed());
    kill_at_random_times(chamber::workdir, COMMAND, |dir| assert_same(dir, &expected));
}

#[test]
fn finished_before() {
    let dir = undisturbed();
    let expected = results(&dir);
    let levels = dir.json("out/report.json")["levels"].clone();
    dir.solver(COMMAND).assert_good();
    assert_same(&dir, &expected);
    assert_eq!(dir.json("out/report.json")["levels"], levels);
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
    assert!(killed(dir.command(COMMAND), || lines() > 1), "over before it was killed");
    dir
}
