//! Readers on random files: none may panic or take long.
//!
//! `FUZZ_SECONDS` is the time for all readers together, and `FUZZ_SEED` where the random numbers begin.
//! A file that fails is written to `build/fuzz`; once what it showed is mended it becomes a
//! regression file, `tests/fuzz/READER/NAME`.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "fuzz/corpus.rs"]
mod corpus;
#[path = "fuzz/mutation.rs"]
mod mutation;

use std::panic::catch_unwind;
use std::path::Path;
use std::time::{Duration, Instant};

use mechanics::math::random::Random;
use mutation::mutate;
use tempfile::TempDir;
use tests::workdir::repository;

/// A reader.
struct Target {
    /// Its name, for regression files and messages.
    name: &'static str,
    /// Reads bytes; must not panic.
    read: fn(&[u8]),
    /// Sound inputs.
    corpus: fn() -> Vec<Vec<u8>>,
}

/// All readers.
const TARGETS: &[Target] = &[
    Target { name: "stl", read: |b| surface(b, "a.stl"), corpus: || corpus::surface("stl") },
    Target { name: "obj", read: |b| surface(b, "a.obj"), corpus: || corpus::surface("obj") },
    Target { name: "ply", read: |b| surface(b, "a.ply"), corpus: || corpus::surface("ply") },
    Target {
        name: "msh",
        read: |b| read(b, "a.msh", |p| mesh::io::read_tets(p).map(drop)),
        corpus: corpus::msh,
    },
    Target {
        name: "vtu",
        read: |b| read(b, "a.vtu", |p| mesh::io::vtu::read_vtu(p).map(drop)),
        corpus: corpus::vtu,
    },
    Target {
        name: "npy",
        read: |b| read(b, "a.npy", |p| mesh::io::npy::read_f64(p).map(drop)),
        corpus: corpus::npy,
    },
    Target {
        name: "checkpoint",
        read: |b| {
            let value = |p: &Path| program::read_checkpoint::<Vec<f64>>(p, "fuzz 1").map(drop);
            read(b, "checkpoint.json", value);
        },
        corpus: corpus::checkpoint,
    },
    Target {
        name: "geo",
        read: |b| drop(cad2fem::mesher::script::without_reach(b)),
        corpus: || corpus::pipelines("model.geo"),
    },
    Target {
        name: "model.toml",
        read: |b| read(b, "model.toml", |p| cad2fem::implicit::ModelFile::read(p, &[]).map(drop)),
        corpus: || corpus::pipelines("model.toml"),
    },
    Target {
        name: "cad2fem.toml",
        read: |b| {
            read(b, "cad2fem.toml", |p| {
                cad2fem::tetmesh::config::Config::read(Some(p), &[]).map(drop)
            })
        },
        corpus: || corpus::pipelines("cad2fem.toml"),
    },
    Target {
        name: "tags.toml",
        read: |b| read(b, "tags.toml", |p| tagger::config::Config::read(p, &[]).map(drop)),
        corpus: || corpus::pipelines("tags.toml"),
    },
    Target {
        name: "sim.toml",
        read: |b| read(b, "sim.toml", |p| scene::config::SimConfig::read(p).map(drop)),
        corpus: || corpus::pipelines("sim.toml"),
    },
    Target {
        name: "design.toml",
        read: |b| read(b, "design.toml", |p| scene::config::DesignConfig::read(p).map(drop)),
        corpus: || corpus::pipelines("design.toml"),
    },
    Target {
        name: "mold.toml",
        read: |b| read(b, "mold.toml", |p| fab::config::Config::read(Some(p), &[]).map(drop)),
        corpus: || corpus::pipelines("mold.toml"),
    },
    Target {
        name: "3mf",
        read: |b| read(b, "a.3mf", |p| mesh::io::threemf::read(p).map(drop)),
        corpus: corpus::threemf,
    },
    Target {
        name: "polyfem",
        read: |b| {
            let options = polyfem::Options::default();
            read(b, "scene.json", |p| polyfem::read(p, &options).map(drop));
        },
        corpus: corpus::polyfem,
    },
];

fn surface(bytes: &[u8], name: &str) {
    read(bytes, name, |path| {
        let surface = mesh::io::read_surface(path)?;
        let _ = mesh::check::check_surface(&surface);
        Ok::<_, mesh::io::IoError>(())
    });
}

thread_local! {
    // a disk would be a hundred times as slow as most readers
    static FOLDER: TempDir = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap();
}

/// Puts the bytes into a file and reads it; a value is as good as an error.
fn read<E>(bytes: &[u8], name: &str, reader: impl FnOnce(&Path) -> Result<(), E>) {
    FOLDER.with(|folder| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let _ = reader(&path);
    });
}

/// Nothing that these files hold is large; a busy machine may take its time.
const LONG: Duration = Duration::from_secs(10);

/// What is wrong with the reader on these bytes.
fn failure(target: &Target, bytes: &[u8]) -> Option<String> {
    let start = Instant::now();
    if catch_unwind(|| (target.read)(bytes)).is_err() {
        return Some("panics".into());
    }
    let time = start.elapsed();
    (time > LONG).then(|| format!("takes {:.0} s", time.as_secs_f64()))
}

/// Tries all readers for so long together.
fn campaign(seconds: f64, seed: u64) {
    let each = Duration::from_secs_f64(seconds / TARGETS.len() as f64);
    let mut failures = Vec::new();
    for target in TARGETS {
        let corpus = (target.corpus)();
        let (start, mut cases) = (Instant::now(), 0);
        while start.elapsed() < each {
            // each case has its own random numbers, so that it can be made again alone
            let bytes = mutate(&corpus, &mut Random::new(seed + (cases << 8)));
            if let Some(what) = failure(target, &bytes) {
                let file = repository().join(format!("build/fuzz/{}-{seed}-{cases}", target.name));
                std::fs::create_dir_all(file.parent().unwrap()).unwrap();
                std::fs::write(&file, &bytes).unwrap();
                failures.push(format!("{} {what}: {}", target.name, file.display()));
            }
            cases += 1;
        }
        eprintln!("{:<14} {cases:>9} cases from seed {seed}", target.name);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn sound_files_and_what_once_failed() {
    for target in TARGETS {
        let mut inputs = (target.corpus)();
        let folder = repository().join("tests/fuzz").join(target.name);
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        inputs.extend(files.map(|file| std::fs::read(file.path()).unwrap()));
        for bytes in inputs {
            assert_eq!(failure(target, &bytes), None, "{}", target.name);
        }
    }
}

#[test]
fn a_few_seconds_of_random_files() {
    campaign(4.0, 1);
}

#[test]
#[ignore = "as long as FUZZ_SECONDS says: make fuzz"]
fn as_long_as_asked() {
    let number = |name: &str| std::env::var(name).ok()?.parse::<f64>().ok();
    campaign(number("FUZZ_SECONDS").unwrap_or(60.0), number("FUZZ_SEED").unwrap_or(1.0) as u64);
}
