//! `--starts`: the same design from several starts side by side, and the best of them.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Result, ensure};
use design::History;
use design::folder::report;
use measure::objective::Weight;
use program::{Heartbeat, KeyPath, Process, Unusable, misfit};
use reports::{Designed, Optimization};
use scene::config::DesignConfig;

use super::Arguments;
use run::report::table;

/// What the starts came to.
const TABLE: &str = "starts.csv";
const COLUMNS: [&str; 7] =
    ["start", "objective_before", "objective_after", "shapes", "time_s", "usable", "status"];
/// How often the programs are asked whether they have ended.
const EVERY: Duration = Duration::from_millis(100);

/// What a start came to.
struct Outcome {
    number: usize,
    folder: PathBuf,
    end: Option<Optimization>,
}

/// Weights that shares come to are those of one start.
pub(super) fn check(design: &DesignConfig) -> Result<()> {
    let share = design.objective.iter().find(|term| matches!(term.weight(), Weight::Share(_)));
    ensure!(
        share.is_none(),
        misfit!(
            share.map_or_else(|| KeyPath::list("objective"), |term| term.title().key("share")),
            ": each of --starts would have another weight; expected weight = … in place of it"
        )
    );
    Ok(())
}

/// Designs from all starts, each in a folder of its own; the folder of the best.
pub(super) fn best(arguments: &Arguments) -> Result<PathBuf> {
    let [checkpoint, path] = ["checkpoint.json", TABLE].map(|name| arguments.output.join(name));
    ensure!(
        arguments.restart || !checkpoint.exists() || path.exists(),
        "{}: is of a design of one start; expected another folder for --starts, or --restart",
        checkpoint.display()
    );
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = arguments.starts.min(threads);
    let mut waiting: Vec<usize> = (1..=arguments.starts).rev().collect();
    let mut running: Vec<(usize, Process)> = Vec::new();
    let mut heartbeat = Heartbeat::start();
    while !waiting.is_empty() || !running.is_empty() {
        while running.len() < at_once
            && let Some(number) = waiting.pop()
        {
            running.push((number, spawn(arguments, number, threads / at_once)?));
        }
        std::thread::sleep(EVERY);
        let mut still = Vec::new();
        for (number, process) in running {
            match process.try_wait()? {
                Some(_) => log::info!("{}", outcome(arguments, number).in_words()),
                None => still.push((number, process)),
            }
        }
        running = still;
        heartbeat.say(|| progress(arguments, &running));
    }
    let all: Vec<Outcome> = (1..=arguments.starts).map(|k| outcome(arguments, k)).collect();
    let titles = COLUMNS.map(str::to_owned).to_vec();
    table::write(&path, [titles].into_iter().chain(all.iter().map(Outcome::row)))?;
    let usable = all.iter().filter_map(|one| Some((one.objective()?, one)));
    let best = usable.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, one)| one);
    let best = best.ok_or_else(|| {
        let said: Vec<String> = all.iter().map(Outcome::in_words).collect();
        Unusable(format!(
            "none of {} starts came to a usable design: {}",
            all.len(),
            said.join("; ")
        ))
    })?;
    log::info!("the best is that of start {}", best.number);
    Ok(best.folder.clone())
}

fn folder_of(arguments: &Arguments, number: usize) -> PathBuf {
    arguments.output.join(format!("start-{number}"))
}

/// The program with one start, its messages in a file.
fn spawn(arguments: &Arguments, number: usize, threads: usize) -> Result<Process> {
    let folder = folder_of(arguments, number);
    mesh::io::make_folder(&folder)?;
    let path = folder.join("log.txt");
    mesh::io::remove_output(&path)?;
    let messages = mesh::io::create_new(&path)?;
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("optimize").arg(&arguments.design).arg("--output").arg(&folder);
    command.arg("--start").arg(number.to_string());
    if arguments.restart {
        command.arg("--restart");
    }
    for change in &arguments.changes.set {
        command.arg("--set").arg(change.to_string());
    }
    command.env("RAYON_NUM_THREADS", threads.max(1).to_string());
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(messages);
    Ok(Process::spawn(&mut command)?)
}

/// What the starts that run have come to.
fn progress(arguments: &Arguments, running: &[(usize, Process)]) -> String {
    let one = |(number, _): &(usize, Process)| {
        let lines = History::new(&folder_of(arguments, *number)).read().unwrap_or_default();
        let objective = lines.last().and_then(|line| line.objective);
        let objective = objective.map_or_else(String::new, |j| format!(", objective {j:.4e}"));
        format!("start {number}: {} shapes{objective}", lines.len())
    };
    running.iter().map(one).collect::<Vec<_>>().join("; ")
}

fn outcome(arguments: &Arguments, number: usize) -> Outcome {
    let folder = folder_of(arguments, number);
    let end = report(&folder).ok().flatten();
    Outcome { number, folder, end }
}

impl Outcome {
    fn designed(&self) -> Option<&Designed> {
        self.end.as_ref()?.designed.as_ref()
    }

    fn is_usable(&self) -> bool {
        self.end.as_ref().is_some_and(|end| end.usable)
    }

    /// The objective of a usable design.
    fn objective(&self) -> Option<f64> {
        self.designed().filter(|_| self.is_usable())?.objective_after
    }

    fn in_words(&self) -> String {
        let number = self.number;
        let (Some(end), Some(designed)) = (&self.end, self.designed()) else {
            let messages = self.folder.join("log.txt");
            return format!("start {number}: no design; see {}", messages.display());
        };
        let [before, after] =
            [designed.objective_before, designed.objective_after].map(|j| j.unwrap_or(f64::NAN));
        format!(
            "start {number}: objective {before:.4e} → {after:.4e}, {} shapes, {:.0} s; {}{}",
            designed.iterations,
            designed.forward_s + designed.gradient_s,
            end.status.in_words(),
            if end.usable { "" } else { ", not usable" }
        )
    }

    /// Its line of the table.
    fn row(&self) -> Vec<String> {
        let of = |number: fn(&Designed) -> Option<f64>| {
            self.designed().and_then(number).map_or_else(String::new, |value| format!("{value:e}"))
        };
        vec![
            self.number.to_string(),
            of(|designed| designed.objective_before),
            of(|designed| designed.objective_after),
            self.designed().map_or(0, |designed| designed.iterations).to_string(),
            of(|designed| Some(designed.forward_s + designed.gradient_s)),
            self.is_usable().to_string(),
            self.end.as_ref().map_or("no design", |end| end.status.in_words()).to_owned(),
        ]
    }
}
