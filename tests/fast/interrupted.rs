//! Programs that are killed, asked to end, or find a full disk: the same command then ends with the same files. And folders
//! in which files are others than those that were written.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use mechanics::math::random::Random;
use mesh::io::{read_surface, write_surface};
use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

use crate::samples::{self, SOFTENING};
use crate::scenarios;

/// A program with its arguments, in a folder with its inputs. All its results are in `out`.
struct Job {
    name: &'static str,
    folder: fn() -> Workdir,
    program: &'static str,
    arguments: &'static str,
}

const fn solver(name: &'static str, folder: fn() -> Workdir, arguments: &'static str) -> Job {
    Job { name, folder, program: "solver", arguments }
}

const DESIGN: &str = "--threads 2 -q optimize design.toml -o out";
const RUN: &str = "--threads 2 -q simulate sim.toml -o out";
const PAST: &str = "--threads 2 -q simulate p1.toml -o out --final-only";

const PLAIN: Job = solver("plain", chamber::workdir, DESIGN);
const CONTACT: Job = solver("contact in time", samples::sliding, RUN);

/// Designs, with the least number of their checkpoints that are killed.
const DESIGNS: [(Job, usize); 5] = [
    // two levels begin, eight states are accepted; the last kill may come too late
    (PLAIN, 8),
    // every level ends as soon as it may: not after its first step, which goes down the gradient
    (solver("stagnating", || changed("first_step = 0.1", "stagnation = 0.9"), DESIGN), 4),
    // the model of the method lies in the checkpoint
    (solver("gauss-newton", gauss_newton, DESIGN), 3),
    (solver("constraints", constrained, DESIGN), 3),
    (solver("scenarios with a share", shared, DESIGN), 3),
];

const OTHERS: [Job; 4] = [
    CONTACT,
    Job {
        name: "model",
        folder: || samples::of_files("model.toml", MODEL),
        program: "cad2fem",
        arguments: "-q model model.toml -o out",
    },
    Job {
        name: "tag",
        folder: tagged,
        program: "tagger",
        arguments: "-q tag body.msh --config tags.toml -o out/tagged.msh",
    },
    Job {
        name: "mold",
        folder: || samples::of_files("mold.toml", MOLD),
        program: "fab",
        arguments: "-q mold body.msh --config mold.toml -o out --no-pictures",
    },
];

/// What softening and relaxation remember lies in the checkpoint.
const REMEMBERING: [Job; 2] =
    [solver("softened", softened, PAST), solver("relaxed", || samples::creeping(400), PAST)];

/// The chamber with a change of its design.
fn changed(old: &str, new: &str) -> Workdir {
    let dir = chamber::workdir();
    let sound = dir.text("design.toml");
    assert!(sound.contains(old), "{old}");
    dir.write("design.toml", &sound.replacen(old, new, 1));
    dir
}

fn gauss_newton() -> Workdir {
    changed("[optimizer]", "[optimizer]\nmethod = \"gauss-newton\"")
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

fn softened() -> Workdir {
    let rises: Vec<f64> = (0..400).map(|i| 4e-3 * (1.0 - (0.05 * f64::from(i)).cos())).collect();
    samples::moved(SOFTENING, &rises)
}

/// A box with a round chamber that opens below.
const MODEL: &str = r#"
unit = "mm"
grid = 1.5
solid = [{ name = "box", shape.box = { center = [0, 0, 8], size = [16, 16, 30] } }]
cavity = [{ name = "hole", shape.sphere = { center = [0, 0, 2], radius = 5 } }]
cut = [{ name = "seat", normal = [0, 0, -1], offset = 0 }]
region = [{ name = "seat", cut = "seat" }, { name = "cavity", cavity = true }, { name = "skin", rest = true }]
"#;

/// The chamber, cast standing on its open end.
const MOLD: &str = r#"
chamber = "cavity"
up = [1, 0, 0]
labels = false
parting = { kind = "plane", pull = [0, 1, 0], offset = 0.02 }
casting = { silicone = "dragon-skin-20", printer = "prusa-mk4" }
"#;

/// The chamber, to be tagged anew by its planes.
fn tagged() -> Workdir {
    let dir = samples::of_files(
        "tags.toml",
        "relative_epsilon = 1e-3\n\
         [[tag]]\nname = \"seat\"\nplane = { point = [0, 0, 0], normal = [-1, 0, 0] }\n\
         [[tag]]\nname = \"skin\"\nbox = { min = [-1, -1, -1], max = [1, 1, 1] }\n",
    );
    std::fs::create_dir(dir.path("out")).unwrap();
    dir
}

/// Files in `out` by their names, without what tells times.
type Files = BTreeMap<String, Vec<u8>>;

fn results(dir: &Workdir) -> Files {
    let mut found = Files::new();
    collect(&dir.path("out"), "", &mut found);
    found
}

fn collect(folder: &Path, prefix: &str, found: &mut Files) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{name}/"), found);
            continue;
        }
        let bytes = std::fs::read(entry.path()).unwrap();
        let bytes = match name.as_str() {
            // hashes of files with times, and times
            "checkpoint.json" | ".lock" => Vec::new(),
            name if name.ends_with(".json") || name.ends_with(".jsonl") => timeless(&bytes),
            _ => bytes,
        };
        found.insert(name, bytes);
    }
}

/// JSON, line by line or as a whole, without times and what else depends on the machine.
fn timeless(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes);
    let values = serde_json::Deserializer::from_str(&text).into_iter::<Value>();
    let mut kept = Vec::new();
    for mut value in values.flatten() {
        forget_times(&mut value);
        kept.extend(value.to_string().into_bytes());
    }
    kept
}

fn forget_times(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|key, _| !key.ends_with("_s") && !OF_THE_RUN.contains(&key.as_str()));
            map.values_mut().for_each(forget_times);
        }
        Value::Array(list) => list.iter_mut().for_each(forget_times),
        _ => {}
    }
}

/// Keys of what a report says of the run, not of its result.
const OF_THE_RUN: [&str; 6] =
    ["timings", "peak_rss_mb", "wall_s_of_this_run", "resumed_after", "work", "threads"];

impl Job {
    fn command(&self, dir: &Workdir) -> Command {
        dir.command_of(self.program, self.arguments)
    }

    /// Runs it to its good end.
    fn finish(&self, dir: &Workdir) -> Files {
        dir.run(self.program, self.arguments).assert_good();
        results(dir)
    }

    /// A folder in which nothing disturbed it.
    fn undisturbed(&self) -> (Workdir, Files) {
        let dir = (self.folder)();
        let files = self.finish(&dir);
        (dir, files)
    }

    /// Runs it to its good end, which is that of one that nothing disturbed, and nothing else is left.
    fn ends_the_same(&self, dir: &Workdir, expected: &Files) {
        let mut found = self.finish(dir);
        // in a folder that is not its own, what was not finished is removed once nobody has touched it for an hour
        found.retain(|file, _| self.name != "tag" || !file.starts_with(".incomplete-"));
        assert!(found.keys().eq(expected.keys()), "{}: {:?}", self.name, found.keys());
        for (file, bytes) in expected {
            assert!(found[file] == *bytes, "{}: {file} differs", self.name);
        }
    }

    /// Starts it and kills it (SIGKILL) as soon as `now` says so; false when it was finished before.
    fn killed(&self, dir: &Workdir, mut now: impl FnMut() -> bool) -> bool {
        let mut child = self.command(dir).stderr(Stdio::null()).spawn().unwrap();
        loop {
            if let Some(status) = child.try_wait().unwrap() {
                assert!(status.success(), "{}: {status}", self.name);
                return false;
            }
            if now() {
                child.kill().unwrap();
                return !child.wait().unwrap().success();
            }
            std::thread::sleep(Duration::from_micros(300));
        }
    }

    /// A folder in which it was killed once it had so many lines of a file.
    fn unfinished(&self, file: &str, least: usize) -> Workdir {
        let dir = (self.folder)();
        let path = dir.path(&format!("out/{file}"));
        let lines = || std::fs::read_to_string(&path).map_or(0, |text| text.lines().count());
        assert!(self.killed(&dir, || lines() >= least), "over before it was killed");
        dir
    }

    /// Asserts that it is refused with words.
    fn refused(&self, dir: &Workdir, words: &[&str]) {
        dir.run(self.program, self.arguments).assert_refused(2, words);
    }
}

#[test]
fn killed_after_every_checkpoint() {
    for (job, least) in DESIGNS {
        let (_, expected) = job.undisturbed();
        let dir = (job.folder)();
        let path = dir.path("out/checkpoint.json");
        let mut kills = 0;
        loop {
            let before = std::fs::read(&path).ok();
            if !job.killed(&dir, || std::fs::read(&path).ok() != before) {
                break;
            }
            kills += 1;
            assert!(kills < 50, "{}: no progress", job.name);
        }
        assert!(kills >= least, "{}: {kills} kills", job.name);
        job.ends_the_same(&dir, &expected);
    }
}

/// How often it was killed in two folders; it may be over before.
fn killed_at_random(job: &Job) -> usize {
    let dir = (job.folder)();
    let clock = Instant::now();
    let expected = job.finish(&dir);
    let whole = clock.elapsed();
    let (mut random, mut kills) = (Random::new(23), 0);
    for _ in 0..2 {
        let dir = (job.folder)();
        for _ in 0..6 {
            let delay = whole.mul_f64(0.5 * (1.0 + random.uniform()));
            let clock = Instant::now();
            if !job.killed(&dir, || clock.elapsed() > delay) {
                break;
            }
            kills += 1;
        }
        job.ends_the_same(&dir, &expected);
    }
    kills
}

#[test]
fn killed_at_random_times() {
    let kills: usize = OTHERS.iter().map(killed_at_random).sum();
    assert!(kills > 0, "all were too fast to be killed");
}

#[test]
#[ignore = "some seconds: runs in make test-all"]
fn what_remembers_its_past_is_killed_at_random_times() {
    let kills: usize = REMEMBERING.iter().map(killed_at_random).sum();
    assert!(kills > 0, "all were too fast to be killed");
}

/// Intermediate load steps need only be solved roughly, so that they agree roughly.
#[test]
fn a_static_run_is_killed_between_its_load_steps() {
    let job = solver("static", many_load_steps, RUN);
    let (whole, _) = job.undisturbed();
    let dir = job.unfinished("checkpoint.json", 1);
    let made = dir.lines("out/steps.jsonl").len();
    let run = dir.solver(&RUN.replace("-q ", ""));
    run.assert_good();
    let continued = run.stderr.split("continuing after ").nth(1).expect("said so");
    let kept: usize = continued.split(' ').next().unwrap().parse().unwrap();
    assert!(kept > 0 && kept <= made, "{kept} of {made}");
    let (found, expected) = (dir.lines("out/steps.jsonl"), whole.lines("out/steps.jsonl"));
    assert_eq!(found.len(), expected.len());
    assert_eq!(found[..kept], expected[..kept], "made before it was killed, by the same steps");
    let near = |a: &Value, b: &Value, tolerance: f64| {
        let [a, b] = [a, b].map(|value| value.as_f64().unwrap());
        assert!((a - b).abs() <= tolerance * b.abs(), "{a} and {b}");
    };
    for (i, (line, expected)) in found.iter().zip(&expected).enumerate() {
        let tolerance = if i + 1 == found.len() { 1e-9 } else { 1e-5 };
        near(&line["work_of_loads"], &expected["work_of_loads"], 1e-5);
        for (name, value) in expected["probes"].as_object().unwrap() {
            near(&line["probes"][name], value, tolerance);
        }
    }
    assert_eq!(dir.files("out"), whole.files("out"));
}

fn many_load_steps() -> Workdir {
    let dir = chamber::workdir();
    let slow = "[solver]\nlargest_load_step = 0.004\n\n[material]";
    dir.write("sim.toml", &(chamber::SIM.replace("[material]", slow) + chamber::PROBES));
    dir
}

#[test]
fn signals_end_it_in_order() {
    let (_, expected) = CONTACT.undisturbed();
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let dir = (CONTACT.folder)();
        let child = CONTACT.command(&dir).stderr(Stdio::piped()).spawn().unwrap();
        while !dir.path("out/checkpoint.json").exists() {
            std::thread::sleep(Duration::from_micros(300));
        }
        let pid = child.id().to_string();
        let sent = Command::new("kill").args(["-s", signal, &pid]).status().unwrap();
        let ended = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert!(sent.success(), "over before the signal: {said}");
        assert_eq!(ended.status.code(), Some(code), "{said}");
        let words = format!("interrupted by SIG{signal}; the same command continues");
        assert!(said.contains(&words), "{said}");
        assert!(!dir.files("out").iter().any(|f| f.starts_with('.')), "{:?}", dir.files("out"));
        CONTACT.ends_the_same(&dir, &expected);
    }
}

/// A limit on the size of files stands for a full disk [KiB].
#[test]
fn a_full_disk_and_then_room() {
    let (_, expected) = PLAIN.undisturbed();
    let mut unwritten = Vec::new();
    for limit in [1, 19, 20] {
        let dir = (PLAIN.folder)();
        let run = dir.solver_on_small_disk(limit, DESIGN);
        run.assert_refused(2, &["out/", "too large"]);
        let files = dir.files("out");
        assert!(!files.iter().any(|f| f.starts_with(".incomplete")), "{files:?}");
        assert!(!files.contains(&"report.json".to_owned()), "{files:?}");
        let file = run.stderr.split("out/").nth(1).and_then(|rest| rest.split(':').next());
        unwritten.push(file.unwrap_or_default().to_owned());
        PLAIN.ends_the_same(&dir, &expected);
    }
    assert_eq!(unwritten, ["level-1.msh", "latest.msh", "result.vtu"]);
}

/// Finished, it stays as it is; without a checkpoint, or with `--restart`, all begins anew.
#[test]
fn finished_before() {
    let (dir, expected) = PLAIN.undisturbed();
    PLAIN.ends_the_same(&dir, &expected);
    std::fs::remove_file(dir.path("out/checkpoint.json")).unwrap();
    PLAIN.ends_the_same(&dir, &expected);
    dir.solver(&format!("{DESIGN} --restart")).assert_good();
    PLAIN.ends_the_same(&dir, &expected);
}

/// The history is the one file that grows in place.
#[test]
fn half_a_line_of_history_is_dropped() {
    let dir = PLAIN.unfinished("history.jsonl", 2);
    // the shape so far is there to be looked at, and gone once it is the design
    assert!(!mesh::io::read_tets(&dir.path("out/latest.msh")).unwrap().tags.facets.is_empty());
    let history = dir.text("out/history.jsonl") + "{\"level\":1,\"hand";
    dir.write("out/history.jsonl", &history);
    PLAIN.ends_the_same(&dir, &PLAIN.undisturbed().1);
}

#[test]
fn unfinished_work_on_other_inputs_is_not_thrown_away() {
    let dir = PLAIN.unfinished("history.jsonl", 2);
    let words = ["out/checkpoint.json", "another problem", "--restart"];
    for (file, from, to) in [
        ("design.toml", "weight = 1e10", "weight = 2e10"),
        ("p1.toml", "8e3", "7e3"),
        ("body.msh", "\n1 0.0 0.0 0.0\n", "\n1 0.0 0.0 1e-9\n"),
    ] {
        let sound = dir.text(file);
        assert!(sound.contains(from), "{file}");
        dir.write(file, &sound.replacen(from, to, 1));
        PLAIN.refused(&dir, &words);
        dir.write(file, &sound);
    }
    let set = dir.solver(&format!("{DESIGN} --set scene.chamber.cavity.pressure=7e3"));
    set.assert_refused(2, &words);
    dir.solver(&format!("{DESIGN} --restart")).assert_good();
    // a finished one is used again
    dir.write("p1.toml", &dir.text("p1.toml").replace("8e3", "7e3"));
    dir.solver(DESIGN).assert_says(&["the finished design there is replaced"]);

    let dir = CONTACT.unfinished("checkpoint.json", 1);
    let words = ["checkpoint.json", "another scene", "steps", "--restart"];
    dir.solver(&format!("{RUN} --set contact.friction=0.5")).assert_refused(2, &words);
    let mut floor = read_surface(&dir.path("floor.stl")).unwrap();
    floor.vertices.iter_mut().for_each(|v| v.z -= 1e-5);
    write_surface(&dir.path("floor.stl"), &floor).unwrap();
    CONTACT.refused(&dir, &words);
}

/// One digit of each checkpoint and of the files of a design from which it continues, checkpoints that are none, and
/// histories that are too short.
#[test]
fn altered_files_are_never_used() {
    let with = |job: &Job, dir: &Workdir, name: &str, text: &[u8], words: &[&str]| {
        let path = dir.path(&format!("out/{name}"));
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, text).unwrap();
        job.refused(dir, &[&[name], words].concat());
        std::fs::write(&path, whole).unwrap();
    };
    let (design, _) = PLAIN.undisturbed();
    let run = CONTACT.unfinished("checkpoint.json", 1);
    let is_run = |name: &String| name.starts_with("run-");
    let state = design.files("out").into_iter().find(is_run).unwrap();
    let of_design = ["checkpoint.json", "history.jsonl", "level-1.msh", "level-2.msh", &state];
    for (job, dir, names) in
        [(&PLAIN, &design, &of_design[..]), (&CONTACT, &run, &["checkpoint.json"])]
    {
        for name in names {
            let mut altered = std::fs::read(dir.path(&format!("out/{name}"))).unwrap();
            let digit = altered.iter().rposition(u8::is_ascii_digit).unwrap();
            altered[digit] = if altered[digit] == b'3' { b'4' } else { b'3' };
            with(job, dir, name, &altered, &["--restart"]);
        }
        let checkpoint = dir.text("out/checkpoint.json");
        for spoiled in ["", "{", &checkpoint[..checkpoint.len() / 2], "[1, 2]", "{\"inputs\": 3}"] {
            with(job, dir, "checkpoint.json", spoiled.as_bytes(), &["column"]);
        }
    }
    with(&PLAIN, &design, "history.jsonl", b"", &["8"]);
    with(&CONTACT, &run, "steps.jsonl", b"", &["--restart"]);
    design.solver(DESIGN).assert_good();
    run.solver(&format!("{RUN} --restart")).assert_good();
}

#[test]
fn a_second_writer_is_refused() {
    let dir = (PLAIN.folder)();
    let mut first = PLAIN.command(&dir).stderr(Stdio::null()).spawn().unwrap();
    while !dir.path("out/checkpoint.json").exists() {
        assert!(first.try_wait().unwrap().is_none(), "over before the second began");
        std::thread::sleep(Duration::from_millis(1));
    }
    PLAIN.refused(&dir, &["out: another process writes to this folder"]);
    assert!(first.wait().unwrap().success());
    assert!(results(&dir) == PLAIN.undisturbed().1);
}
