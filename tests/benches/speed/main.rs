//! Times single steps and whole solves, compares them with the machine's limits,
//! the last stored run and an independent solver, and prints one table.
//!
//! `make bench`, or `cargo bench -p tests --bench speed -- WORDS` for the rows
//! whose names contain one of the words.
#![allow(missing_docs)]

mod cases;
mod dense;
mod kernels;
mod row;

use anyhow::Result;
use tests::workdir::repository;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&String> = arguments.iter().filter(|a| !a.starts_with("--")).collect();
    let wanted = |key: &str| words.is_empty() || words.iter().any(|w| key.contains(w.as_str()));
    let folder = repository().join("build/bench/criterion");
    let mut kernels = kernels::Kernels::new(&folder, &wanted);
    let mut rows = dense::products();
    let flops = kernels.all("gripper-p2")?;
    rows.extend(dense::factorisations("gripper-p2", flops.unwrap_or(1e9)));
    rows.extend(kernels.rows());
    for row in rows {
        eprintln!(
            "{:24} {:16} {:9.4} s  {}",
            row.what,
            row.body,
            row.seconds.median,
            row.work.rate(row.seconds.median)
        );
    }
    Ok(())
}
