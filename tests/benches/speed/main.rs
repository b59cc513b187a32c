//! Times single steps and whole solves with Criterion.
//!
//! `make bench`, or `make bench ONLY="factor gripper"` for the rows whose names contain all of the words. What a run
//! finds is kept, and `make bench-compare` fails where a row takes more than 10 % longer than when it was last kept,
//! both in units of a dense product of their own run, so that the speed of the machine does not count.
#![allow(missing_docs)]

mod cases;
mod contact;
mod dense;
mod finger;
mod kernels;
mod motion;

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use criterion::{BatchSize, BenchmarkGroup, Criterion, SamplingMode, Throughput};
use tests::workdir::repository;

/// As the program `solver` has it.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Bodies on which every step is timed.
const BODIES: [&str; 4] = ["bar20k-p2", "bar60k-p2", "bar250k-p2", "gripper-p2"];
/// Bodies on which assembly is timed, too.
const DEGREES: [&str; 2] = ["bar60k-p1", "bar60k-p3"];
/// Bodies that are solved as a whole.
const SOLVED: [&str; 7] =
    ["bar20k-p2", "bar60k-p2", "bar100k-p2", "bar250k-p2", "gripper-p1", "gripper-p2", "worm-p2"];
/// Times relative to those that were kept, from which on `make bench-compare` fails.
const LIMIT: f64 = 1.1;
/// The samples that are kept.
const KEPT: &str = "kept";

/// What was timed, and on what.
type Key = [String; 2];

/// Criterion, and the rows that it has timed.
pub struct Bench {
    criterion: Criterion,
    words: Vec<String>,
    timed: Vec<Key>,
}

impl Bench {
    /// Whether a row is asked for.
    pub fn wants(&self, what: &str, body: &str) -> bool {
        let key = format!("{what}/{body}");
        what == dense::PRODUCT || self.words.iter().all(|word| key.contains(word.as_str()))
    }

    /// Times `run` on what `prepare` makes; neither the making nor the end of what `run` returns is counted. `work` is
    /// how much it is.
    pub fn time_with<T, O>(
        &mut self,
        [what, body]: [&str; 2],
        work: Throughput,
        mut prepare: impl FnMut() -> T,
        mut run: impl FnMut(T) -> O,
    ) {
        self.group([what, body], work, |group| {
            group.bench_function(body, |b| {
                b.iter_batched(&mut prepare, &mut run, BatchSize::PerIteration);
            });
        });
    }

    pub fn time<O>(&mut self, key: [&str; 2], work: Throughput, mut run: impl FnMut() -> O) {
        self.time_with(key, work, || (), |()| run());
    }

    /// A row that may be timed in a way of its own.
    pub fn group(
        &mut self,
        [what, body]: [&str; 2],
        work: Throughput,
        time: impl FnOnce(&mut BenchmarkGroup<criterion::measurement::WallTime>),
    ) {
        if self.wants(what, body) {
            let mut group = self.criterion.benchmark_group(what);
            time(group.sampling_mode(SamplingMode::Flat).throughput(work));
            group.finish();
            self.timed.push([what.to_owned(), body.to_owned()]);
        }
    }
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|a| a == "--bench") {
        eprintln!("SKIPPED: benchmarks run by `make bench`");
        return Ok(());
    }
    let compare = arguments.iter().any(|a| a == "--compare");
    // it survives `make clean`
    let folder = repository().join(".cache/bench/criterion");
    let criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_secs(1))
        .without_plots()
        .output_directory(&folder);
    let criterion = match compare {
        true => criterion.retain_baseline(KEPT.to_owned(), false),
        false => criterion.save_baseline(KEPT.to_owned()),
    };
    let words = arguments.into_iter().filter(|a| !a.starts_with("--")).collect();
    let mut bench = Bench { criterion, words, timed: Vec::new() };
    dense::time(&mut bench);
    for body in BODIES {
        kernels::all(&mut bench, body)?;
    }
    for body in DEGREES {
        kernels::assembly(&mut bench, body)?;
    }
    contact::time(&mut bench)?;
    for body in SOLVED {
        kernels::solve(&mut bench, body)?;
    }
    motion::time(&mut bench);
    if compare { compared(&folder, &bench.timed) } else { Ok(()) }
}

/// Times now over those that were kept, in units of the dense product; fails where one is above the limit.
fn compared(folder: &Path, timed: &[Key]) -> Result<()> {
    let ratio = |[what, body]: &Key| -> Result<Option<f64>> {
        let row = folder.join(what).join(body);
        let then = row.join(KEPT).join("sample.json");
        if !then.exists() {
            return Ok(None);
        }
        Ok(Some(median(&row.join("new/sample.json"))? / median(&then)?))
    };
    let product = ratio(&timed[0])?.context("nothing was kept; `make bench` keeps a run")?;
    eprintln!("\nthe dense product takes {product:.2} times as long as when it was kept");
    let mut slower = Vec::new();
    for key in &timed[1..] {
        let name = key.join("/");
        match ratio(key)?.map(|ratio| ratio / product) {
            None => eprintln!("{name}: nothing was kept"),
            Some(ratio) => {
                eprintln!("{name}: {ratio:.2} times as long");
                slower.extend((ratio > LIMIT).then(|| format!("{name}: {ratio:.2}")));
            }
        }
    }
    ensure!(slower.is_empty(), "slower than before:\n  {}", slower.join("\n  "));
    Ok(())
}

/// Median of the times of an iteration that Criterion has left in a file [ns].
fn median(path: &Path) -> Result<f64> {
    #[derive(serde::Deserialize)]
    struct Samples {
        iters: Vec<f64>,
        times: Vec<f64>,
    }
    let samples: Samples = serde_json::from_str(&mesh::io::read_text(path)?)
        .with_context(|| path.display().to_string())?;
    let mut times: Vec<f64> =
        samples.times.iter().zip(&samples.iters).map(|(t, n)| t / n).collect();
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}
