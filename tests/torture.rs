//! Programs that are killed, starved, and given damaged files of their own: they end as they
//! should, and the same command then ends with the same bits.
//!
//! `TORTURE_SECONDS` is the time of a campaign, `TORTURE_SEED` where its random numbers begin, and
//! `TORTURE_CASE` one case of it that is made again alone.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "torture/child.rs"]
mod child;
#[path = "torture/job.rs"]
mod job;
#[path = "torture/mesher.rs"]
mod mesher;
#[path = "torture/trial.rs"]
mod trial;

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use job::{JOBS, Sound};
use solver::math::random::Random;
use trial::{TRIALS, Tally};

/// A number from 0 to 1.
fn part(random: &mut Random) -> f64 {
    0.5 * (1.0 + random.uniform())
}

/// One of so many; 0 of none.
fn any(random: &mut Random, len: usize) -> usize {
    ((part(random) * len as f64) as usize).min(len.saturating_sub(1))
}

/// Cases until the time is over, or the one that is asked for.
fn campaign(seconds: f64, seed: u64, only: Option<usize>) {
    let (start, time) = (Instant::now(), Duration::from_secs_f64(seconds));
    let sound: Vec<OnceLock<Sound>> = JOBS.iter().map(|_| OnceLock::new()).collect();
    let mut tallies = vec![Tally::default(); TRIALS.len()];
    let mut failures = Vec::new();
    let mut case = only.unwrap_or(0);
    while only.map_or(start.elapsed() < time, |only| case == only) {
        // each case has its own random numbers, so that it can be made again alone
        let mut random = Random::new(seed + ((case as u64) << 8));
        let (name, trial) = TRIALS[case % TRIALS.len()];
        let tally = &mut tallies[case % TRIALS.len()];
        let any = any(&mut random, JOBS.len());
        let job = sound[any].get_or_init(|| Sound::new(&JOBS[any]));
        tally.cases += 1;
        if let Err(what) = trial(job, &mut random, tally) {
            tally.failures += 1;
            failures.push(format!("case {case} of seed {seed}: {name}, {}: {what}", job.job.name));
            eprintln!("{}", failures[failures.len() - 1]);
        }
        case += 1;
    }
    eprintln!(
        "{:<14} {:>6} {:>14} {:>9}   seed {seed}",
        "trial", "cases", "interruptions", "failures"
    );
    for ((name, _), Tally { cases, interruptions, failures }) in TRIALS.iter().zip(&tallies) {
        eprintln!("{name:<14} {cases:>6} {interruptions:>14} {failures:>9}");
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn from_environment(seconds: f64) {
    let number = |name: &str| std::env::var(name).ok()?.parse::<f64>().ok();
    let seconds = number("TORTURE_SECONDS").unwrap_or(seconds);
    let seed = number("TORTURE_SEED").unwrap_or(1.0) as u64;
    campaign(seconds, seed, number("TORTURE_CASE").map(|case| case as usize));
}

#[test]
fn twenty_seconds() {
    campaign(20.0, 1, None);
}

#[test]
#[ignore = "five minutes, or as long as TORTURE_SECONDS says: make torture"]
fn as_long_as_asked() {
    from_environment(300.0);
}
