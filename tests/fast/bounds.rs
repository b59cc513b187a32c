//! What SECURITY.md says is bounded, a little beyond: refused with the bound, before memory is taken.

use std::fmt::Write as _;
use std::fs;

use tests::chamber;
use tests::workdir::{Workdir, repository};

#[test]
fn what_is_beyond_a_bound_is_refused() {
    let dir = chamber::workdir();
    let steps = "simulate p1.toml --set time.end=1 --set time.steps=1000001 --set material.density=1e3 -o out";
    dir.solver(steps).assert_refused(2, &["steps = 1000001: must lie between 1 and 1000000"]);
    dir.solver("simulate p1.toml --threads 1025 -o out").assert_refused(2, &["0..=1024"]);
    let model = repository().join("pipelines/blank/model.toml");
    fs::copy(model, dir.path("model.toml")).unwrap();
    let run = |arguments: &str| dir.run("cad2fem", arguments);
    run("model model.toml --set grid=0.01 -o out").assert_refused(2, &["more than 3e7"]);
    run("model model.toml --set grid=1e-31 -o out").assert_refused(2, &["from 1e-30 to 1e30"]);
    assert!(!dir.path("out").exists());
}

#[test]
fn coordinates_beyond_any_body_are_refused() {
    let dir = Workdir::new();
    for (name, text) in [
        ("a.obj", "v 0 0 0\nv 1e155 0 0\nv 0 1 0\nf 1 2 3\n"),
        (
            "a.stl",
            "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1.1e9 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n",
        ),
    ] {
        dir.write(name, text);
        let run = dir.run("cad2fem", &format!("info {name}"));
        run.assert_refused(2, &[name, "1 of 3 vertices are beyond 1e9"]);
    }
}

/// Rows and columns of triangles of which all intersect: counting ends before all pairs.
#[test]
fn counting_of_intersections_ends() {
    let dir = Workdir::new();
    let n = 2000_i32;
    let mut text = String::new();
    for i in 0..n {
        writeln!(text, "v -1 {i} 0\nv {} {i} 0\nv {} {i}.1 0", n + 1, n + 1).unwrap();
        writeln!(text, "v {i}.5 {} -1\nv {i}.5 {} -1\nv {i}.5 {} 1", -n, 2 * n, n / 2).unwrap();
    }
    (0..2 * n).for_each(|t| writeln!(text, "f {} {} {}", 3 * t + 1, 3 * t + 2, 3 * t + 3).unwrap());
    dir.write("rows.obj", &text);
    let run = dir.run("cad2fem", "info rows.obj --check");
    let found = run.stdout.split("at least ").nth(1).and_then(|rest| rest.split(' ').next());
    let found: i32 = found.unwrap_or_else(|| panic!("{run:?}")).parse().unwrap();
    assert!((1_000_000..n * n / 2).contains(&found), "{found} of {} pairs", n * n);
}
