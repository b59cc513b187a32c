//! Limits of pressures and paths by arc length, by the program, on a block with a chamber.

use serde_json::Value;
use tests::chamber::{self, PRESSURE};
use tests::workdir::Workdir;

/// The scene of the chamber with more tables.
fn with(more: &str) -> Workdir {
    let dir = chamber::workdir();
    let text = dir.text("sim.toml");
    dir.write("edge.toml", &format!("{text}\n{more}"));
    dir
}

#[track_caller]
fn refused(more: &str, words: &[&str]) {
    let dir = with(more);
    dir.solver("simulate edge.toml -o out").assert_refused(2, words);
    assert!(!dir.path("out/report.json").exists());
}

/// A thick block bears more than is asked for, and its state at the end is stable.
#[test]
fn a_block_is_stable_to_what_is_asked_for() {
    let dir = with("[limit]\nmost = 1.3\n[solver]\nstability = true\n");
    let run = dir.solver("simulate edge.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("stable to 1.3"), "{}", run.stderr);
    let report = dir.json("out/report.json");
    assert_eq!(report["limit"]["status"], "stable-to");
    assert_eq!(report["limit"]["factor"], Value::Null);
    assert_eq!(report["limit"]["stable_to"], 1.3);
    assert_eq!(report["stability"]["negative_eigenvalues"], 0);
    let softer = report["stability"]["stiffness_over_rest"].as_f64().unwrap();
    assert!((0.1..2.0).contains(&softer), "{softer}");
}

/// Along the arc length the same states are passed as along the load.
#[test]
fn a_path_comes_to_the_full_load() {
    let dir = with("[solver]\nfollow = \"arc-length\"\n");
    dir.solver("simulate edge.toml -o out").assert_good();
    dir.solver("simulate sim.toml -o load").assert_good();
    let volume = |folder: &str| {
        let report = dir.json(&format!("{folder}/report.json"));
        report["chambers"]["cavity"]["volume"].as_f64().unwrap()
    };
    assert!((volume("out") / volume("load") - 1.0).abs() < 1e-9);
    let text = dir.text("out/steps.jsonl");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() > 2, "{text}");
    let arcs: Vec<f64> =
        lines.iter().map(|line| line["path"]["arc_length"].as_f64().unwrap()).collect();
    assert!(arcs.windows(2).all(|pair| pair[0] < pair[1]), "{arcs:?}");
    for line in &lines {
        let pressure = line["chambers"]["cavity"]["pressure"].as_f64().unwrap();
        let load = line["load"].as_f64().unwrap();
        assert!((pressure - load * PRESSURE).abs() < 1e-9 * PRESSURE);
        assert_eq!(line["path"]["stability"]["negative_eigenvalues"], 0);
    }
}

/// What was asked for and not reached is no result, unless the path is what is asked for.
#[test]
fn a_path_that_ends_early_is_not_usable() {
    let dir = with("[solver]\nfollow = \"arc-length\"\npath_states = 2\n");
    dir.solver("simulate edge.toml -o out")
        .assert_refused(1, &["full load", "path_states", "path_only"]);
    let report = dir.json("out/report.json");
    assert_eq!(
        (&report["usable"], &report["status"]),
        (&false.into(), &"full load not reached".into())
    );
    let load = report["load_reached"].as_f64().unwrap();
    assert!((0.01..0.5).contains(&load), "{load}");
    let alone = dir.text("edge.toml").replace("path_states", "path_only = true\npath_states");
    dir.write("alone.toml", &alone);
    dir.solver("simulate alone.toml -o alone").assert_good();
    let report = dir.json("alone/report.json");
    assert_eq!((&report["usable"], &report["load_reached"]), (&true.into(), &load.into()));
}

#[test]
fn what_has_no_limit_or_path_is_refused() {
    refused("[limit]\non = [\"top\"]\n", &["[limit]", "top", "cavity"]);
    refused("[limit]\nmost = 0.5\n", &["most", "above 1"]);
    refused(
        "[limit]\n[time]\nend = 1\nsteps = 2\nmethod = \"quasistatic\"\n",
        &["[limit]", "[time]"],
    );
    refused("[solver]\npath_states = 3\n", &["path_states", "arc-length"]);
    refused("[solver]\npath_only = true\n", &["path_only", "arc-length"]);
    refused("[solver]\nfollow = \"arc-length\"\npath_states = 0\n", &["path_states", "one state"]);
}

/// The gradient of the term is that of the factor by the shape, and the design bears more.
#[test]
fn a_design_moves_away_from_its_limit() {
    let dir = chamber::near_its_limit();
    let one_level =
        dir.text("design.toml").replace("[[shape.level]]\nhandles = 3\niterations = 3\n", "");
    dir.write("design.toml", &one_level);
    dir.solver("check design.toml --handles 3 --steps 5 --random 1").assert_good();
    dir.solver("optimize design.toml -o out").assert_good();
    let text = dir.text("out/history.jsonl");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let factor = |line: &Value| line["probes"]["limit"].as_f64().unwrap();
    let term = |line: &Value| line["terms"]["limit"].as_f64().unwrap();
    let (first, last) = (&lines[0], lines.last().unwrap());
    assert!(factor(first) > 1.0 && factor(first) < 3.0, "{first}");
    assert!(factor(last) > factor(first) + 0.1, "{first} {last}");
    for line in &lines {
        let expected = 100.0 * (3.0 - factor(line)).max(0.0).powi(2);
        assert!((term(line) - expected).abs() < 1e-9 * expected.max(1.0), "{line}");
    }
    // the limit that is followed from shape to shape is one of the path, and next to the first
    dir.write("end.toml", &dir.text("p1.toml").replace("body.msh", "out/design.msh"));
    dir.solver("simulate end.toml -o end").assert_good();
    let found = dir.json("end/report.json")["limit"]["factor"].as_f64().unwrap();
    assert!(found < factor(last) * (1.0 + 1e-6), "{found} {last}");
    assert!(found > 0.98 * factor(last), "{found} {last}");
}

#[test]
fn a_limit_that_a_design_cannot_have_is_refused() {
    let refused = |from: &str, to: &str, words: &[&str]| {
        let dir = chamber::near_its_limit();
        dir.write("design.toml", &dir.text("design.toml").replace(from, to));
        dir.solver("optimize design.toml -o out").assert_refused(2, words);
    };
    refused("least = 3", "least = 1", &["least", "above 1"]);
    refused("least = 3", "least = 5", &["least", "most = 4"]);
    refused("weight = 100", "weight = -1", &["[limit]", "weight"]);
    let dir = chamber::near_its_limit();
    let slope = "slope = { least = 0.9, weight = 1 }\n";
    dir.write("design.toml", &(dir.text("design.toml") + slope));
    dir.write("p1.toml", &(dir.text("p1.toml") + "\n[contact]\nactivation = 1e-4\n"));
    dir.solver("optimize design.toml -o out").assert_refused(2, &["slope", "[contact]", "least"]);
    let dir = chamber::near_its_limit();
    dir.write("p1.toml", &dir.text("p1.toml").replace("[limit]\nmost = 4\n", ""));
    dir.solver("optimize design.toml -o out").assert_refused(2, &["[limit]", "scene"]);
}

/// The factors of the limit and of the burst change with the modulus in proportion, as pressure is the only load; by one
/// number of the law they and the slope are compared with two other runs.
#[test]
fn limits_have_error_bars() {
    let dir = chamber::near_its_edges();
    let scene = dir.text("p1.toml");
    let uncertain = "\n[uncertainty]\nmodulus = 0.1\nnumbers = { \"material.body.c1\" = 1e3 }\n";
    let edges = |c1: f64, more: &str| {
        dir.write("other.toml", &(scene.replace("c1 = 55e3", &format!("c1 = {c1}")) + more));
        let run = dir.solver("simulate other.toml -o other --restart");
        run.assert_good();
        (dir.json("other/report.json")["limit"].clone(), run.stderr)
    };
    let (found, said) = edges(55e3, uncertain);
    let (more, less) = (edges(55.05e3, "").0, edges(54.95e3, "").0);
    for key in ["factor", "burst", "slope"] {
        let number = |report: &Value| report[key].as_f64().unwrap();
        let bars = &found["error_bars"][key];
        assert_eq!(bars["value"], found[key]);
        let by = |of: &str| {
            let all = bars["bars"].as_array().unwrap();
            all.iter().find(|bar| bar["of"] == of).unwrap()["derivative"].as_f64().unwrap()
        };
        let (by_modulus, by_c1) = (by("modulus"), by("material.body.c1"));
        if key != "slope" {
            assert!((by_modulus / number(&found) - 1.0).abs() < 1e-6, "{by_modulus} {found}");
        }
        let slope = (number(&more) - number(&less)) / 100.0;
        assert!((by_c1 / slope - 1.0).abs() < 1e-4, "{key} {by_c1} {slope}");
        assert!(said.contains(&format!("limit: {key} ")), "{said}");
    }
}

/// The gradient of a term is that of its number by the shape, the law and the pressure; the design raises the number by
/// `more`, and the report of the designed body has the same one. The limit is not sought.
fn a_design_raises(dir: &Workdir, name: &str, least: f64, more: f64) {
    dir.solver("check design.toml --handles 3 --steps 5 --random 1").assert_good();
    dir.solver("optimize design.toml -o out").assert_good();
    let text = dir.text("out/history.jsonl");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let number = |line: &Value| line["probes"][name].as_f64().unwrap();
    let (first, last) = (&lines[0], lines.last().unwrap());
    assert!(number(last) > number(first) + more, "{first} {last}");
    for line in &lines {
        assert_eq!([&line["terms"]["limit"], &line["probes"]["limit"]], [&Value::Null; 2]);
        let (term, expected) =
            (line["terms"][name].as_f64().unwrap(), 100.0 * (least - number(line)).powi(2));
        assert!(number(line) < least && (term - expected).abs() < 1e-9 * expected, "{line}");
    }
    dir.write("end.toml", &dir.text("p1.toml").replace("body.msh", "out/design.msh"));
    dir.solver("simulate end.toml -o end").assert_good();
    let found = dir.json("end/report.json")["limit"][name].as_f64().unwrap();
    assert!((found / number(last) - 1.0).abs() < 1e-6, "{found} {last}");
}

#[test]
fn a_design_moves_away_from_its_burst() {
    let dir = chamber::near_its_edges();
    let design =
        dir.text("design.toml").replace("[[shape.level]]\nhandles = 3\niterations = 3\n", "");
    let design = design.replace("least = 3\nweight = 100\nburst", "burst");
    dir.write("design.toml", &design);
    a_design_raises(&dir, "burst", 3.0, 0.02);
}

#[test]
fn a_design_makes_its_pressure_rise_more_steeply() {
    let dir = chamber::near_its_limit();
    let text = dir.text("design.toml");
    let goal = "least = 3\nweight = 100";
    assert!(text.contains(goal), "{text}");
    dir.write("design.toml", &text.replace(goal, "slope = { least = 0.9, weight = 100 }"));
    a_design_raises(&dir, "slope", 0.9, 0.01);
}

/// What balloons before it tears counts the factor of the limit, and says so.
#[test]
fn a_body_that_comes_to_its_limit_first_counts_that_as_its_burst() {
    let dir = chamber::near_its_edges();
    let tough = dir.text("p1.toml").replace(chamber::STRETCH_AT_BREAK, "stretch_at_break = 90");
    dir.write("p1.toml", &tough);
    let one = dir.text("design.toml").replace("iterations = 3", "iterations = 1");
    dir.write("design.toml", &one);
    let run = dir.solver("optimize design.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("before the stretch at break"), "{}", run.stderr);
    for line in dir.text("out/history.jsonl").lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        assert_eq!(line["probes"]["burst"], line["probes"]["limit"]);
        assert_eq!(line["terms"]["burst"], line["terms"]["limit"]);
    }
}

#[test]
fn a_burst_that_a_design_cannot_have_is_refused() {
    let refused = |file: &str, from: &str, to: &str, words: &[&str]| {
        let dir = chamber::near_its_edges();
        let text = dir.text(file);
        assert!(text.contains(from), "{text}");
        dir.write(file, &text.replace(from, to));
        dir.solver("optimize design.toml -o out").assert_refused(2, words);
    };
    let goal = chamber::BURST_GOAL;
    refused("design.toml", goal, "burst = { least = 1, weight = 1 }", &["burst", "above 1"]);
    refused("design.toml", goal, "burst = { least = 5, weight = 1 }", &["burst", "most = 4"]);
    refused("design.toml", goal, "burst = { least = 2, weight = 0 }", &["burst", "positive"]);
    refused(
        "design.toml",
        "least = 3\nweight = 100\nburst",
        "weight = 100\nburst",
        &["weight", "without least"],
    );
    let both = format!("least = 3\nweight = 100\n{goal}");
    refused("design.toml", &both, "", &["[limit]", "empty", "burst = {"]);
    refused("design.toml", "name = \"clear\"", "name = \"burst\"", &["burst", "another"]);
    refused("design.toml", goal, "slope = { least = 0, weight = 1 }", &["slope", "above 0"]);
    refused(
        "p1.toml",
        chamber::STRETCH_AT_BREAK,
        "",
        &["burst", "no material", "stretch_at_break"],
    );
}
