//! The same sweep on this machine and on a cluster.

use std::fs;
use std::path::Path;
use std::process::Command;

use tests::skip::skip;
use tests::workdir::{Workdir, program, repository};

use super::run;

/// Columns that say how long something took, or how much memory.
const MEASURED: [&str; 3] = ["seconds", "wall_s", "peak_rss_mb"];

/// Runs four beams, and returns their table without what is measured.
fn beams(out: &Path, arguments: &str) -> Vec<Vec<String>> {
    let programs = program("solver");
    let mut command = Command::new(repository().join(".venv-sweep/bin/python"));
    command
        .arg(repository().join("pipelines/sweep/sweep.py"))
        .arg(out.with_file_name("sweep.toml"));
    command.arg("-o").arg(out).args(arguments.split_whitespace());
    run(command.env("PUFFER_BIN", programs.parent().unwrap()));
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).from_path(out.join("table.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let keep: Vec<usize> =
        (0..rows[0].len()).filter(|&i| !MEASURED.contains(&&rows[0][i])).collect();
    rows.iter().map(|row| keep.iter().map(|&i| row[i].to_owned()).collect()).collect()
}

#[test]
#[ignore = "needs Slurm: runs in make test-cluster"]
fn sweep_on_slurm_has_the_same_table() {
    let there = Command::new("sinfo").output().is_ok_and(|output| output.status.success());
    if !there || !repository().join(".venv-sweep/installed").exists() {
        return skip("no Slurm answers here (sinfo), or the Python packages of sweeps are missing");
    }
    let dir = Workdir::new();
    let from = repository().join("pipelines/beam");
    for file in ["model.toml", "cad2fem.toml", "tags.toml", "sim.toml", "sim.sweep.toml"] {
        fs::copy(from.join(file), dir.path(file)).unwrap();
    }
    let text = fs::read_to_string(from.join("sweep.toml")).unwrap();
    assert!(text.contains("cases = 100"));
    dir.write("sweep.toml", &text.replace("cases = 100", "cases = 4"));
    let local = beams(&dir.path("local"), "");
    // a Slurm without accounting has no sacct
    let slurm = "--executor slurm --jobs 2 --cores 2 --slurm-status-command squeue --group-components cases=2";
    assert_eq!(local, beams(&dir.path("slurm"), slurm));
    assert_eq!(local.len(), 5);
}
