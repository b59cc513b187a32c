//! Bodies that nothing holds: what balances is solved, what does not is refused.

use mesh::io::write_tets;
use tests::workdir::Workdir;
use tests::{block, tag};

const SCENE: &str = r#"
mesh = "body.msh"
degree = 1

[material]
kind = "neo-hookean"
young = 1e5
poisson = 0.4
density = 1000.0
"#;

/// A cube of 15 mm with a hollow cell in its middle.
fn hollow(more: &str) -> Workdir {
    let dir = Workdir::new();
    let inside = |c: f64| (4.9e-3..10.1e-3).contains(&c);
    let body = tag(
        block([3, 3, 3], 5e-3, |c| c == [1, 1, 1], |p| p),
        &[
            ("air", &|c| inside(c.x) && inside(c.y) && inside(c.z)),
            ("top", &|c| c.z > 0.015 - 1e-9),
            ("bottom", &|c| c.z < 1e-9),
            ("sides", &|_| true),
        ],
    );
    write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).expect("a folder");
    dir.write("sim.toml", &format!("{SCENE}{more}"));
    dir
}

const AIR: &str = "[[chamber]]\non = \"air\"\npressure = 5e3\n";

#[test]
fn a_closed_body_needs_no_support() {
    let dir = hollow(AIR);
    let run = dir.solver("simulate sim.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("nothing holds the body"), "{}", run.stderr);
    let report = dir.json("out/report.json");
    let afloat = report["chambers"]["air"]["volume"].as_f64().expect("a volume");
    // the same held in its corner by planes, which take nothing away
    let held = hollow(&format!("{AIR}[contact]\nactivation = 1e-5\n"));
    held.solver("simulate sim.toml -o out").assert_good();
    let volume = held.json("out/report.json")["chambers"]["air"]["volume"].as_f64().expect("one");
    assert!((afloat / volume - 1.0).abs() < 1e-9, "{afloat} {volume}");
    let middle = &report["tags"]["air"]["mean_displacement_vector"];
    let off = (0..3).map(|k| middle[k].as_f64().expect("a number").abs()).fold(0.0, f64::max);
    assert!(off < 1e-7, "it stays where it is: {middle}");
}

#[test]
fn loads_that_do_not_balance_are_refused() {
    let pulled = "[[traction]]\non = \"top\"\ntraction = [0, 0, 100]\n";
    for load in ["gravity = [0, 0, -9.81]\n", pulled] {
        let (gravity, table) = if load.starts_with('g') { (load, "") } else { ("", load) };
        let dir = hollow(&format!("{AIR}{table}"));
        let text = dir.text("sim.toml");
        dir.write("sim.toml", &format!("{gravity}{text}"));
        let words = ["nothing holds the body", "do not balance", "[[fixed]]"];
        dir.solver("simulate sim.toml -o out").assert_refused(2, &words);
    }
    let both = format!("{AIR}{pulled}[[traction]]\non = \"bottom\"\ntraction = [0, 0, -100]\n");
    hollow(&both).solver("simulate sim.toml -o out").assert_good();
}
