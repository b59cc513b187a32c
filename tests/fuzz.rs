//! Readers on random files: none may panic or take long.
//!
//! `FUZZ_SECONDS` is the time for all readers together, and `FUZZ_SEED` where the random numbers begin.
//! A file that fails is written to `build/fuzz`; once what it showed is mended it becomes a
//! regression file, `tests/fuzz/READER/NAME`.
#![allow(missing_docs, clippy::unwrap_used)]

use std::panic::catch_unwind;
use std::time::{Duration, Instant};

use mechanics::math::random::Random;
use tests::chamber;
use tests::fuzz::{TARGETS, Target, mutate, numbers};
use tests::workdir::repository;

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

/// All of them take half an hour: `make fuzz` tries one in ten, others for every seed.
#[test]
#[ignore = "minutes: make fuzz"]
fn numbers_at_the_limits_in_every_key() {
    let seed = std::env::var("FUZZ_SEED").map_or(1, |seed| seed.parse().unwrap());
    let failures = numbers::campaign(&chamber::workdir(), 10, seed);
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn some_numbers_at_the_limits() {
    let failures = numbers::campaign(&chamber::workdir(), 397, 1);
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}
