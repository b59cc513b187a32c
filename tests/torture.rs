//! Programs that are killed, given a full disk, and given damaged files of their own: they end as they
//! should, and the same command then ends with the same bits.
//!
//! `TORTURE_SECONDS` is the time of a campaign, `TORTURE_SEED` where its random numbers begin, and
//! `TORTURE_CASE` one case of it that is made again alone.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "torture/cad.rs"]
mod cad;
#[path = "torture/child.rs"]
mod child;
#[path = "torture/job.rs"]
mod job;
#[path = "torture/trial.rs"]
mod trial;

use std::num::NonZero;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use job::{JOBS, Sound};
use mechanics::math::random::Random;
use trial::{TRIALS, Tally};

/// A number from 0 to 1.
fn part(random: &mut Random) -> f64 {
    0.5 * (1.0 + random.uniform())
}

/// One of so many; 0 of none.
fn any(random: &mut Random, len: usize) -> usize {
    ((part(random) * len as f64) as usize).min(len.saturating_sub(1))
}

/// Cases until the time is over, one on each core, or the one that is asked for.
fn campaign(seconds: f64, seed: u64, only: Option<usize>) {
    let (start, time) = (Instant::now(), Duration::from_secs_f64(seconds));
    let sound: Vec<OnceLock<Sound>> = JOBS.iter().map(|_| OnceLock::new()).collect();
    let next = AtomicUsize::new(only.unwrap_or(0));
    let goes_on = |case| only.map_or(start.elapsed() < time, |only| case == only);
    let worker = || {
        let mut tallies = vec![Tally::default(); TRIALS.len()];
        let cases = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        for case in cases.take_while(|&case| goes_on(case)) {
            attempt(case, seed, &sound, &mut tallies[case % TRIALS.len()]);
        }
        tallies
    };
    let workers = std::thread::available_parallelism().map_or(1, NonZero::get);
    let tallies: Vec<Vec<Tally>> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        handles.into_iter().map(|handle| handle.join().unwrap()).collect()
    });
    report(seed, &tallies);
}

/// One case. It has its own random numbers, so that it can be made again alone.
fn attempt(case: usize, seed: u64, sound: &[OnceLock<Sound>], tally: &mut Tally) {
    let mut random = Random::new(seed + ((case as u64) << 8));
    let (name, trial) = TRIALS[case % TRIALS.len()];
    let any = any(&mut random, JOBS.len());
    let job = sound[any].get_or_init(|| Sound::new(&JOBS[any]));
    tally.cases += 1;
    if let Err(what) = trial(job, &mut random, tally) {
        let failure = format!("case {case} of seed {seed}: {name}, {}: {what}", job.job.name);
        eprintln!("{failure}");
        tally.failures.push(failure);
    }
}

/// One line for each kind of trial, summed over the workers.
fn report(seed: u64, tallies: &[Vec<Tally>]) {
    eprintln!(
        "{:<14} {:>6} {:>14} {:>9}   seed {seed}",
        "trial", "cases", "interruptions", "failures"
    );
    for (kind, (name, _)) in TRIALS.iter().enumerate() {
        let sum =
            |number: fn(&Tally) -> usize| tallies.iter().map(|t| number(&t[kind])).sum::<usize>();
        let (cases, interruptions) = (sum(|t| t.cases), sum(|t| t.interruptions));
        let failures = sum(|t| t.failures.len());
        eprintln!("{name:<14} {cases:>6} {interruptions:>14} {failures:>9}");
    }
    let failures: Vec<&str> =
        tallies.iter().flatten().flat_map(|t| &t.failures).map(String::as_str).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn five_seconds() {
    campaign(5.0, 1, None);
}

#[test]
#[ignore = "five minutes, or as long as TORTURE_SECONDS says: make torture"]
fn as_long_as_asked() {
    let number = |name: &str| std::env::var(name).ok()?.parse::<f64>().ok();
    let seconds = number("TORTURE_SECONDS").unwrap_or(300.0);
    let seed = number("TORTURE_SEED").unwrap_or(1.0) as u64;
    campaign(seconds, seed, number("TORTURE_CASE").map(|case| case as usize));
}
