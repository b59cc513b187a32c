//! Readers on random files: none may panic or take long.
//!
//! `FUZZ_SECONDS` is the time for all readers together, and `FUZZ_SEED` where the random numbers begin.
//! A file that fails is written to `build/fuzz`; once what it showed is mended it becomes a
//! regression file, `tests/fuzz/FILE/NAME`.
#![allow(missing_docs, clippy::unwrap_used)]

mod corpus;
mod mutation;

use std::panic::catch_unwind;
use std::path::Path;
use std::time::{Duration, Instant};

use mechanics::math::random::Random;
use mutation::mutate;
use polyfem::Options;
use scene::config::{DesignConfig, SimConfig};
use tempfile::TempDir;
use tests::workdir::repository;

/// A reader.
struct Target {
    /// What its files are called.
    file: &'static str,
    /// Reads a file; must not panic, and a value is as good as an error.
    read: fn(&Path),
    /// Sound files of this name.
    corpus: fn(&str) -> Vec<Vec<u8>>,
}

const fn target(file: &'static str, read: fn(&Path), corpus: fn(&str) -> Vec<Vec<u8>>) -> Target {
    Target { file, read, corpus }
}

/// All readers.
const TARGETS: &[Target] = &[
    target("a.stl", surface, corpus::surface),
    target("a.obj", surface, corpus::surface),
    target("a.ply", surface, corpus::surface),
    target("a.msh", |path| drop(mesh::io::read_tets(path)), corpus::msh),
    target("a.vtu", |path| drop(mesh::io::vtu::read_vtu(path)), corpus::vtu),
    target("a.npy", |path| drop(mesh::io::npy::read_f64(path)), corpus::npy),
    target("a.3mf", |path| drop(mesh::io::threemf::read(path)), corpus::threemf),
    target(
        "checkpoint.json",
        |path| drop(program::read_checkpoint::<Vec<f64>>(path, "fuzz 1")),
        corpus::checkpoint,
    ),
    target("scene.json", |path| drop(polyfem::read(path, &Options::default())), corpus::polyfem),
    target(
        "model.geo",
        |path| drop(cad2fem::mesher::script::without_reach(&std::fs::read(path).unwrap())),
        corpus::pipelines,
    ),
    target("model.toml", |path| drop(implicit::ModelFile::read(path, &[])), corpus::pipelines),
    target(
        "cad2fem.toml",
        |path| drop(cad2fem::tetmesh::config::Config::read(Some(path), &[])),
        corpus::pipelines,
    ),
    target("tags.toml", |path| drop(tagger::config::Config::read(path, &[])), corpus::pipelines),
    target("sim.toml", |path| drop(SimConfig::read(path)), corpus::pipelines),
    target("design.toml", |path| drop(DesignConfig::read(path)), corpus::pipelines),
    target("mold.toml", |path| drop(fab::config::Config::read(Some(path), &[])), corpus::pipelines),
];

fn surface(path: &Path) {
    let _ = mesh::io::read_surface(path).map(|surface| mesh::check::check_surface(&surface));
}

thread_local! {
    // a disk would be a hundred times as slow as most readers
    static FOLDER: TempDir = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap();
}

/// Nothing that these files hold is large; a busy machine may take its time.
const LONG: Duration = Duration::from_secs(10);

/// What is wrong with the reader on these bytes.
fn failure(target: &Target, bytes: &[u8]) -> Option<String> {
    let path = FOLDER.with(|folder| folder.path().join(target.file));
    std::fs::write(&path, bytes).unwrap();
    let start = Instant::now();
    if catch_unwind(|| (target.read)(&path)).is_err() {
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
        let corpus = (target.corpus)(target.file);
        let (start, mut cases) = (Instant::now(), 0);
        while start.elapsed() < each {
            // each case has its own random numbers, so that it can be made again alone
            let bytes = mutate(&corpus, &mut Random::new(seed + (cases << 8)));
            if let Some(what) = failure(target, &bytes) {
                let file = repository().join(format!("build/fuzz/{}-{seed}-{cases}", target.file));
                std::fs::create_dir_all(file.parent().unwrap()).unwrap();
                std::fs::write(&file, &bytes).unwrap();
                failures.push(format!("{} {what}: {}", target.file, file.display()));
            }
            cases += 1;
        }
        eprintln!("{:<14} {cases:>9} cases from seed {seed}", target.file);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn sound_files_and_what_once_failed() {
    for target in TARGETS {
        let mut inputs = (target.corpus)(target.file);
        let folder = repository().join("tests/fuzz").join(target.file);
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        inputs.extend(files.map(|file| std::fs::read(file.path()).unwrap()));
        for bytes in inputs {
            assert_eq!(failure(target, &bytes), None, "{}", target.file);
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
