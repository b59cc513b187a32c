//! `solver map`: a table equals single runs, its derivatives their differences, its stiffness the answer to tractions.

use std::collections::BTreeMap;

use nalgebra::Matrix6;
use tests::chamber::{self, PROBES, SIM};
use tests::workdir::Workdir;

/// The rows of a table, by columns.
fn table(dir: &Workdir, name: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(dir.path(name)).unwrap();
    let columns = reader.headers().unwrap().clone();
    let row = |row: csv::StringRecord| {
        columns.iter().map(str::to_owned).zip(row.iter().map(str::to_owned)).collect()
    };
    reader.records().map(|record| row(record.unwrap())).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row.get(column).unwrap_or_else(|| panic!("{column}: {row:?}")).parse().unwrap()
}

fn workdir() -> Workdir {
    let dir = chamber::workdir();
    let traction = "\n[[traction]]\non = \"top\"\ntraction = [0, 0, 0]\n";
    dir.write(
        "sim.toml",
        &format!("{}{PROBES}{traction}", SIM.replace("degree = 2", "degree = 1")),
    );
    dir
}

#[test]
fn rows_are_runs_and_slopes_their_differences() {
    let dir = workdir();
    let grid = "--grid material.body.c1=50e3,55e3 --grid chamber.cavity.pressure=0:2e3:8e3";
    dir.solver(&format!("map sim.toml {grid} --tip top -o map.csv")).assert_good();
    let rows = table(&dir, "map.csv");
    assert_eq!(rows.len(), 10);
    assert!(rows.iter().all(|row| row["status"] == "ok"));
    let path = "chamber.cavity.pressure";
    assert_eq!([number(&rows[9], "material.body.c1"), number(&rows[9], path)], [55e3, 8e3]);
    let probes = &dir.report("simulate sim.toml -o run --final-only")["probes"];
    for name in ["top", "air"] {
        let alone = probes[name]["value"].as_f64().unwrap();
        assert!((number(&rows[9], name) / alone - 1.0).abs() < 1e-8, "{name}: {alone}");
    }
    // Simpson's rule over the slopes of 0 to 8 kPa is the change
    for name in ["top", "air", "tip.x", "tip.z", "tip.ry"] {
        let slope = |i: usize| number(&rows[5 + i], &format!("d {name}/d {path}"));
        let sum =
            2e3 / 3.0 * (slope(0) + 4.0 * slope(1) + 2.0 * slope(2) + 4.0 * slope(3) + slope(4));
        let change = number(&rows[9], name) - number(&rows[5], name);
        assert!((sum / change - 1.0).abs() < 1e-4, "{name}: {sum} {change}");
    }
}

#[test]
fn the_stiffness_is_the_inverse_of_what_tractions_do() {
    let dir = workdir();
    let axes = ["x", "y", "z"];
    let by: String = axes.iter().map(|axis| format!(" --by traction.top.{axis}")).collect();
    dir.solver(&format!(
        "map sim.toml --grid chamber.cavity.pressure=8e3 --tip top{by} -o map.csv"
    ))
    .assert_good();
    let row = &table(&dir, "map.csv")[0];
    let names = ["x", "y", "z", "rx", "ry", "rz"];
    let entry = |i: usize, j: usize| {
        let [i, j] = [i.min(j), i.max(j)];
        number(row, &format!("k.{}.{}", names[i], names[j]))
    };
    let compliance =
        Matrix6::from_fn(entry).try_inverse().unwrap().fixed_columns::<3>(0).into_owned();
    let largest = compliance.amax();
    // the top has 50 × 40 mm: a force of 2e-3 N per Pa
    for i in 0..3 {
        for (j, axis) in axes.iter().enumerate() {
            let slope = number(row, &format!("d tip.{}/d traction.top.{axis}", names[i])) / 2e-3;
            assert!(
                (slope - compliance[(i, j)]).abs() < 1e-6 * largest,
                "{i} {j}: {slope} {compliance:?}"
            );
        }
    }
}

#[test]
fn rows_without_an_equilibrium_are_marked() {
    let dir = workdir();
    dir.solver("map sim.toml --grid chamber.cavity.pressure=4e3,4e6,5e3 -o map.csv").assert_good();
    let rows = table(&dir, "map.csv");
    let status: Vec<&str> = rows.iter().map(|row| row["status"].as_str()).collect();
    assert_eq!(status, ["ok", "no equilibrium", "ok"]);
    assert!(number(&rows[1], "top").is_nan() && number(&rows[2], "top") > 0.0);
    dir.solver("map sim.toml --grid chamber.cavity.pressure=4e6 -o none.csv")
        .assert_refused(1, &["no row"]);
}

#[test]
fn a_table_that_is_killed_continues_with_the_same_bits() {
    let dir = workdir();
    dir.write("sim.toml", &dir.text("sim.toml").replace("degree = 1", "degree = 3"));
    let map = "map sim.toml --grid chamber.cavity.pressure=0:100:5e3 --tip top -o";
    dir.solver(&format!("{map} whole.csv")).assert_good();
    let mut killed = dir.command(&format!("{map} map.csv")).spawn().unwrap();
    let checkpoint = dir.path(".map.csv.checkpoint.json");
    while !checkpoint.exists() && killed.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(!dir.path("map.csv").exists(), "it was too fast to be killed");
    dir.solver(&format!("{map} map.csv")).assert_says(&["continuing after row"]);
    assert_eq!(dir.text("map.csv"), dir.text("whole.csv"));
    assert!(!checkpoint.exists());
}

#[test]
fn tables_that_cannot_be_are_refused() {
    let dir = workdir();
    let refused = |arguments: &str, words: &[&str]| {
        dir.solver(&format!("map sim.toml {arguments} -o map.csv")).assert_refused(2, words);
    };
    refused("--grid chamber.cavity.pressure", &["FROM:STEP:TO"]);
    refused(
        "--grid chamber.cavity.presure=1",
        &["chamber.cavity.presure", "chamber.cavity.pressure"],
    );
    refused("--grid chamber.cavity.pressure=1 --tip tpo", &["tpo", "top"]);
    refused("--grid chamber.cavity.pressure=1 --grid chamber.cavity.pressure=2", &["twice"]);
    dir.write(
        "sim.toml",
        &format!("{SIM}\n[time]\nend = 1\nsteps = 2\nmethod = \"quasistatic\"\n"),
    );
    refused("--grid chamber.cavity.pressure=1", &["[time]"]);
}
