//! `solver optimize` and `check` given design problems that they cannot use.

use tests::chamber::{self, beyond_any_equilibrium};

/// A change of `design.toml`, and what the message must say.
type Case = (&'static str, &'static str, &'static [&'static str]);

/// Files of which none may be there after a refusal.
const RESULTS: [&str; 5] =
    ["design.msh", "history.jsonl", "report.json", "result.vtu", "checkpoint.json"];

fn refuse(cases: &[Case]) {
    for (from, to, words) in cases {
        let dir = chamber::workdir();
        let sound = dir.text("design.toml");
        assert!(sound.contains(from), "{from:?}");
        dir.write("design.toml", &sound.replacen(from, to, 1));
        for arguments in ["optimize design.toml -o out", "check design.toml"] {
            dir.solver(arguments).assert_refused(2, words);
        }
        let files = dir.files("out");
        assert!(!RESULTS.iter().any(|r| files.contains(&(*r).to_owned())), "{to}: {files:?}");
    }
}

#[test]
fn settings() {
    refuse(&[
        (
            "first_step",
            "frist_step",
            &["design.toml", "unknown field `frist_step`", "`stagnation`"],
        ),
        (
            "first_step",
            "largest_step = 0.0\nfirst_step",
            &["design.toml", "largest_step = 0: must be"],
        ),
        ("spacing", "spaces", &["design.toml", "unknown field `spaces`", "`spacing`"]),
        ("kind = \"target\"", "kind = \"goal\"", &["design.toml", "`goal`", "`clearance`"]),
        ("weight = 1e10", "weight = nan", &["design.toml", "objective \"top\": weight = NaN"]),
        ("weight = 1e10", "weight = -1.0", &["design.toml", "objective \"top\": weight = -1"]),
        ("weight = 1e10", "weight = \"big\"", &["design.toml", "invalid type", "big"]),
        ("spacing = 2e-3", "spacing = 0.0", &["design.toml", "spacing = 0 m must be positive"]),
        ("minimum = 2e-3", "minimum = -1.0", &["design.toml", "minimum = -1 m must be positive"]),
        ("handles = 1", "handles = 0", &["design.toml", "handles = 0", "one handle or more"]),
        ("p1.toml", "none.toml", &["none.toml", "No such file"]),
        ("target.stl", "none.stl", &["none.stl", "No such file"]),
        ("target.stl", "p1.toml", &["p1.toml", "unknown surface format"]),
    ]);
}

#[test]
fn no_level_and_no_objective() {
    let dir = chamber::workdir();
    let sound = dir.text("design.toml");
    let (head, objectives) = sound.split_at(sound.find("[[objective]]").unwrap());
    let (shape, _) = head.split_at(head.find("[[shape.level]]").unwrap());
    let problem = |text: &str| {
        dir.write("design.toml", text);
        dir.solver("optimize design.toml -o out")
    };
    problem(&format!("{shape}{objectives}")).assert_refused(2, &["missing field `level`"]);
    let empty = format!("{shape}level = []\n{objectives}");
    problem(&empty).assert_refused(2, &["design.toml", "no [[shape.level]]"]);
    problem(head).assert_refused(2, &["design.toml", "missing field `objective`"]);
    problem(&format!("objective = []\n{head}")).assert_refused(2, &["no [[objective]]"]);
    assert!(!dir.path("out").exists());
}

#[test]
fn what_the_body_does_not_allow() {
    refuse(&[
        // all walls are 10 mm
        (
            "minimum = 2e-3",
            "minimum = 10.1e-3",
            &["design.toml", "\"wall\"", "1.000e-2 m thin", "1.010e-2 m"],
        ),
        ("against = [\"top\"", "against = [\"seat\"", &["design.toml", "objective \"wall\""]),
        (
            "on = \"cavity\"",
            "on = \"hole\"",
            &["design.toml", "\"hole\"", "seat, cavity, top, skin"],
        ),
        ("on = \"top\"", "on = \"lid\"", &["design.toml", "\"lid\"", "seat, cavity, top, skin"]),
        ("handles = 1", "handles = 1000", &["design.toml", "1000 handles", "33 vertices"]),
    ]);
}

/// A first try that was refused must not obstruct the second.
#[test]
fn a_corrected_problem_starts_in_the_same_folder() {
    let dir = chamber::workdir();
    let sound = dir.text("design.toml");
    dir.write("design.toml", &sound.replace("handles = 1\n", "handles = 1000\n"));
    dir.solver("optimize design.toml -o out").assert_refused(2, &["1000 handles"]);
    dir.write("design.toml", &sound);
    dir.solver("optimize design.toml -o out").assert_good();
}

#[test]
fn no_equilibrium_at_the_start() {
    let dir = chamber::workdir();
    dir.write("p1.toml", &beyond_any_equilibrium(&dir.text("p1.toml")));
    for arguments in ["optimize design.toml -o out", "check design.toml"] {
        let run = dir.solver(arguments);
        run.assert_refused(run.code.unwrap_or(0).max(1), &["no equilibrium", "% of the load"]);
    }
}

/// As for `simulate`: the program ran, but there is no result.
#[test]
fn no_equilibrium_at_the_start_has_the_exit_code_of_simulate() {
    let dir = chamber::workdir();
    dir.write("p1.toml", &beyond_any_equilibrium(&dir.text("p1.toml")));
    for arguments in ["optimize design.toml -o out", "check design.toml"] {
        dir.solver(arguments).assert_refused(1, &["no equilibrium"]);
    }
}

#[test]
fn arguments_of_the_check() {
    let dir = chamber::workdir();
    let words: &[&str] = &["1000 handles", "33 vertices"];
    dir.solver("check design.toml --handles 1000").assert_refused(2, words);
    dir.solver("check design.toml --steps many").assert_refused(2, &["--steps", "many"]);
    // none of these could give a slope
    for [option, value] in [["--handles", "0"], ["--steps", "1"], ["--motion", "0"]] {
        let run = dir.solver(&format!("check design.toml {option} {value}"));
        run.assert_refused(2, &[option, value]);
    }
}

#[test]
fn gauss_newton_is_refused_for_more_variables_than_it_takes() {
    let dir = chamber::workdir();
    let body = chamber::refined(2);
    mesh::io::write_tets(&dir.path("body.msh"), &body.mesh, &body.tags).unwrap();
    let free = dir.text("design.toml").replace("handles = 1\n", "vertices = true\n");
    dir.write("design.toml", &free);
    let run = dir.solver("optimize design.toml -o out --set optimizer.method=gauss-newton");
    run.assert_refused(2, &["level 1: ", "variables, of which", "at most 400", "l-bfgs"]);
    assert!(!dir.path("out/report.json").exists());
}
