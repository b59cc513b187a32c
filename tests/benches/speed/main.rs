//! Times single steps and whole solves, compares them with the machine's limits,
//! the last stored run and an independent solver, and prints one table.
//!
//! `make bench`, or `make bench ONLY="factor gripper"` for the rows whose names
//! contain all of the words. Only full runs are stored. `make bench-compare` fails where
//! a row takes more than 10 % longer than in the last stored run of the same machine.
#![allow(missing_docs)]

mod cases;
mod contact;
mod dense;
mod finger;
mod history;
mod kernels;
mod motion;
mod row;
mod scaling;
mod solves;
mod stored;
mod table;

use std::io::Write;

use anyhow::{Result, ensure};
use stored::Stored;
use tests::workdir::repository;

/// As the program `solver` has it.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Bodies on which every step is timed.
const BODIES: [&str; 4] = ["bar20k-p2", "bar60k-p2", "bar250k-p2", "gripper-p2"];
/// Bodies on which assembly is timed, too.
const DEGREES: [&str; 2] = ["bar60k-p1", "bar60k-p3"];
/// Times relative to those of the stored run from which on `make bench-compare` fails.
const LIMIT: f64 = 1.1;
/// Published bodies that are solved as a whole.
const PUBLISHED: [&str; 3] = ["gripper-p1", "gripper-p2", "worm-p2"];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments[..] {
        [flag, name] if flag == "--solve" => return solves::child(name),
        [flag, name] if flag == "--contact" => return contact::child(name),
        _ => {}
    }
    if !arguments.iter().any(|a| a == "--bench") {
        eprintln!("SKIPPED: benchmarks run by `make bench`");
        return Ok(());
    }
    let compare = arguments.iter().any(|a| a == "--compare");
    run(&arguments.into_iter().filter(|a| !a.starts_with("--")).collect::<Vec<_>>(), compare)
}

fn run(words: &[String], compare: bool) -> Result<()> {
    let wanted = |key: &str| words.iter().all(|w| key.contains(w.as_str()));
    let folder = repository().join("build/bench");
    std::fs::create_dir_all(&folder)?;
    // beside the cache of meshes: it survives `make clean`
    let kept = repository().join(".cache/bench/history.jsonl");
    let mut history = Stored::history(&kept)?;
    let mut now = Stored::begin();
    let before = history.iter().rev().find(|run| run.machine == now.machine);
    ensure!(
        before.is_some() || !compare,
        "{}: no stored run of this machine ({}) to compare with; `make bench` stores one",
        kept.display(),
        now.machine
    );

    let bars = cases::BARS.map(|(name, _)| format!("{name}-p2"));
    let solved: Vec<&str> = bars.iter().map(String::as_str).chain(PUBLISHED).collect();
    let solved: Vec<&str> =
        solved.into_iter().filter(|name| wanted(&format!("static solve/{name}"))).collect();
    if ["dgemm", "sgemm", "triad"].iter().any(|what| wanted(what)) || !solved.is_empty() {
        now.rows.extend(dense::limits());
    }
    let mut kernels = kernels::Kernels::new(folder.join("criterion"), &wanted);
    for body in BODIES {
        kernels.all(body)?;
        let rows = kernels.take_rows();
        // at once, since the speed of shared machines drifts
        if let Some(row::Work::Flops(flops)) = row::find(&rows, "factor", body).map(|r| r.work) {
            now.rows.extend(dense::factorisations(body, flops));
        }
        now.rows.extend(rows);
    }
    for body in DEGREES {
        kernels.assembly_of(body)?;
    }
    now.rows.extend(kernels.take_rows());
    now.rows.extend(contact::rows(&wanted)?);
    let moving = motion::rows(&wanted)?;
    now.rows.extend(moving.iter().map(|(row, _)| row.clone()));

    for name in solved {
        if let Some((row, solve)) = solves::repeat(name)? {
            now.rows.push(row);
            now.solves.push(solve);
        }
    }
    table::compare_dense(&mut now.rows);
    solves::compare(&mut now.rows, &now.solves);

    let mut text = table::render(&now, before);
    let dgemm = dense::fastest_product(&now.rows);
    if !now.solves.is_empty() {
        text += &format!("\n{}", solves::parts(&now.solves, dgemm));
    }
    let timings = now.solves.iter().map(|s| (s.body.clone(), &s.timings));
    let steps = moving.iter().map(|(row, timings)| (format!("{} {}", row.what, row.body), timings));
    let timings: Vec<_> = timings.chain(steps).collect();
    if !timings.is_empty() {
        text += &format!("\n{}", solves::busy_cores(timings.into_iter()));
    }
    let of_bars: Vec<_> = now.solves.iter().filter(|s| bars.contains(&s.body)).cloned().collect();
    let size = "degrees of freedom";
    let fits = [
        scaling::report("bars", size, scaling::of_bars(&of_bars), &folder.join("scaling.svg"))?,
        scaling::report(
            "sheets",
            "triangles",
            contact::curves(&now.rows),
            &folder.join("contact.svg"),
        )?,
    ];
    for fit in fits.into_iter().flatten() {
        text += &format!("\n{fit}");
    }
    let targets = solves::targets(&now.rows, &now.solves, dgemm);
    if !targets.is_empty() {
        text += &format!("\n{}\n", targets.join("\n"));
    }
    write!(std::io::stdout(), "\n{text}")?;
    let slower = before.map_or(Vec::new(), |before| table::slower(&now, before, LIMIT));
    if words.is_empty() {
        now.keep(&kept)?;
        let machine = now.machine.clone();
        history.push(now);
        let picture = history::picture(&history, &machine, &folder.join("history.svg"))?;
        let picture = picture.unwrap_or_default();
        write!(std::io::stdout(), "{picture}")?;
        text += &picture;
        mesh::io::write_atomic(&folder.join("table.txt"), |out| write!(out, "{text}"))?;
    }
    ensure!(!compare || slower.is_empty(), "slower than before:\n  {}", slower.join("\n  "));
    Ok(())
}
