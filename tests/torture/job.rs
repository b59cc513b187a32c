//! What is run, and what it must leave.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::Value;
use tests::workdir::Workdir;
use tests::{chamber, fall};

use crate::child;

/// A program with its arguments, in a folder with its inputs. All its results are under `out`.
pub struct Job {
    pub name: &'static str,
    program: &'static str,
    arguments: &'static str,
    pub workdir: fn() -> Workdir,
    /// Whether it continues where it was, from files of its own.
    pub continues: bool,
    /// Whether no other program writes to its folder. Elsewhere what a killed program has not
    /// finished is removed once nobody has touched it for an hour.
    owns: bool,
}

pub const JOBS: &[Job] = &[
    Job {
        name: "optimize",
        program: "solver",
        arguments: "--threads 2 -q optimize design.toml -o out",
        workdir: chamber::workdir,
        continues: true,
        owns: true,
    },
    Job {
        name: "simulate",
        program: "solver",
        arguments: "--threads 2 -q simulate sim.toml -o out",
        workdir: fall::workdir,
        continues: true,
        owns: true,
    },
    Job {
        name: "model",
        program: "cad2fem",
        arguments: "-q model model.toml -o out",
        workdir: model,
        continues: false,
        owns: true,
    },
    Job {
        name: "tag",
        program: "tagger",
        arguments: "-q tag body.msh --config tags.toml -o out/tagged.msh",
        workdir: tag,
        continues: false,
        owns: false,
    },
    Job {
        name: "mold",
        program: "fab",
        arguments: "-q mold body.msh --config mold.toml -o out --no-pictures",
        workdir: mold,
        continues: false,
        owns: true,
    },
];

impl Job {
    /// The command, in a folder of [`Self::workdir`].
    pub fn command(&self, dir: &Workdir) -> Command {
        dir.command_of(self.program, self.arguments)
    }

    /// The same by a shell, after a line of its own.
    pub fn after(&self, dir: &Workdir, line: &str) -> Command {
        let own = self.command(dir);
        let mut command = Command::new("bash");
        command.args(["-c", &format!("{line}; exec \"$0\" \"$@\"")]);
        command.arg(own.get_program()).args(own.get_args()).current_dir(dir.path("."));
        command
    }
}

/// A job that nothing disturbed.
pub struct Sound {
    pub job: &'static Job,
    /// How long it took.
    pub time: Duration,
    results: BTreeMap<String, Vec<u8>>,
}

impl Sound {
    /// Runs it.
    pub fn new(job: &'static Job) -> Self {
        let dir = (job.workdir)();
        let clock = Instant::now();
        let end = child::run(job.command(&dir)).and_then(|end| end.expect(&[0]));
        end.unwrap_or_else(|what| panic!("{}: {what}", job.name));
        let time = clock.elapsed();
        Self { job, time, results: results(&dir) }
    }

    /// The largest file [B].
    pub fn largest(&self) -> usize {
        self.results.values().map(Vec::len).max().unwrap_or(0)
    }

    /// Runs the command once more, which must now end well, with the same bits and no litter.
    pub fn ends_the_same(&self, dir: &Workdir) -> Result<(), String> {
        child::run(self.job.command(dir))?.expect(&[0])?;
        self.is_same(dir)
    }

    /// The same bits and no litter.
    pub fn is_same(&self, dir: &Workdir) -> Result<(), String> {
        let found = results(dir);
        for (name, bytes) in &self.results {
            match found.get(name) {
                None => return Err(format!("{name} is missing")),
                Some(other) if other != bytes => return Err(format!("{name} differs")),
                Some(_) => {}
            }
        }
        let allowed = |name: &str| !self.job.owns && name.starts_with(".incomplete-");
        let unknown = |name: &&String| !self.results.contains_key(*name) && !allowed(name);
        match found.keys().find(unknown) {
            Some(name) => Err(format!("{name} is left behind")),
            None => Ok(()),
        }
    }
}

/// Files below `out` without what tells times.
fn results(dir: &Workdir) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    collect(&dir.path("out"), "", &mut found);
    found
}

fn collect(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
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
const OF_THE_RUN: &[&str] =
    &["timings", "peak_rss_mb", "wall_s_of_this_run", "resumed_after", "work", "threads"];

/// A box with a round chamber that opens below.
fn model() -> Workdir {
    let dir = Workdir::new();
    dir.write(
        "model.toml",
        "unit = \"mm\"\ngrid = 1.5\n\
         [[solid]]\nname = \"box\"\nshape.box = { center = [0, 0, 8], size = [16, 16, 30] }\n\
         [[cavity]]\nname = \"hole\"\nshape.sphere = { center = [0, 0, 2], radius = 5 }\n\
         [[cut]]\nname = \"seat\"\nnormal = [0, 0, -1]\noffset = 0\n\
         [[region]]\nname = \"seat\"\ncut = \"seat\"\n\
         [[region]]\nname = \"cavity\"\ncavity = true\n\
         [[region]]\nname = \"skin\"\nrest = true\n",
    );
    dir
}

/// The chamber, to be tagged anew by its planes.
fn tag() -> Workdir {
    let dir = chamber::workdir();
    std::fs::create_dir(dir.path("out")).unwrap();
    dir.write(
        "tags.toml",
        "relative_epsilon = 1e-3\n\
         [[tag]]\nname = \"seat\"\nplane = { point = [0, 0, 0], normal = [-1, 0, 0] }\n\
         [[tag]]\nname = \"skin\"\nbox = { min = [-1, -1, -1], max = [1, 1, 1] }\n",
    );
    dir
}

/// The chamber, cast standing on its open end.
fn mold() -> Workdir {
    let dir = chamber::workdir();
    dir.write(
        "mold.toml",
        "chamber = \"cavity\"\nup = [1, 0, 0]\nlabels = false\n\
         [parting]\nkind = \"plane\"\npull = [0, 1, 0]\noffset = 0.02\n\
         [casting]\nsilicone = \"dragon-skin-20\"\nprinter = \"prusa-mk4\"\n",
    );
    dir
}
