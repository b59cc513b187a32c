//! `solver optimize` and `solver check` on a design problem of two levels, and on those that they cannot use.

use serde_json::Value;
use tests::chamber;
use tests::reported::number;
use tests::workdir::Workdir;

fn optimized() -> (Workdir, Vec<Value>) {
    let dir = chamber::workdir();
    dir.solver("optimize design.toml -o out").assert_good();
    let lines = dir.lines("out/history.jsonl");
    (dir, lines)
}

/// Scripts rely on these keys; the chapter "Results" of the book lists them.
#[test]
fn the_history_has_one_line_per_accepted_iteration() {
    let (dir, lines) = optimized();
    let place = |l: &Value| ["level", "handles", "iteration"].map(|k| l[k].as_u64().unwrap());
    let expected: Vec<[u64; 3]> =
        [(1, 1), (2, 3)].iter().flat_map(|&(l, h)| (0..4).map(move |i| [l, h, i])).collect();
    assert_eq!(lines.iter().map(place).collect::<Vec<_>>(), expected);
    for line in &lines {
        for key in ["gradient_norm", "forward_s", "gradient_s", "time_s"] {
            assert!(number(&line[key]) > 0.0, "{key} in {line}");
        }
        let terms = line["terms"].as_object().unwrap();
        assert_eq!(terms.keys().collect::<Vec<_>>(), ["clear", "smooth", "top", "wall"]);
        let sum: f64 = terms.values().map(number).sum();
        assert!((sum / number(&line["objective"]) - 1.0).abs() < 1e-14, "{line}");
    }
    for pair in lines.windows(2).filter(|pair| pair[0]["level"] == pair[1]["level"]) {
        assert!(number(&pair[1]["objective"]) < number(&pair[0]["objective"]), "{pair:?}");
    }
    let report = dir.json("out/report.json");
    assert_eq!(report["status"], "still_falling");
    assert_eq!(report["objective_before"], lines[0]["objective"]);
    assert_eq!(report["objective_after"], lines[7]["objective"]);
    let fall = 1.0 - number(&lines[7]["objective"]) / number(&lines[0]["objective"]);
    eprintln!("the objective fell by {:.1} %", 100.0 * fall);
    // the target is within reach of handles on the cavity; this much in six steps
    assert!(fall > 0.2, "{fall}");
}

/// The designed body is the old one with another cavity, and behaves as the
/// history says.
#[test]
fn the_design_moves_the_cavity_and_nothing_else() {
    let (dir, lines) = optimized();
    let design = mesh::io::read_tets(&dir.path("out/design.msh")).unwrap();
    let body = chamber::chamber();
    assert_eq!(design.tags, body.tags);
    assert_eq!(mesh::check::check_tets(&design.mesh).len(), 0);
    let mut moves = vec![true; body.mesh.vertices.len()];
    for tag in ["seat", "top", "skin"] {
        body.facets(tag).unwrap().into_iter().flatten().for_each(|v| moves[v] = false);
    }
    let moved = |v: usize| (design.mesh.vertices[v] - body.mesh.vertices[v]).norm();
    let cavity = body.facets("cavity").unwrap();
    let largest = cavity.iter().flatten().map(|&v| moved(v)).fold(0.0, f64::max);
    // the first step alone is a tenth of an edge of 10 to 17 mm
    assert!(largest > 1e-3, "{largest}");
    assert!((0..moves.len()).filter(|&v| !moves[v]).all(|v| moved(v) == 0.0));

    let tags = dir.report("simulate p1.toml --mesh out/design.msh -o again")["tags"].clone();
    for (tag, mean) in lines[7]["mean_displacement"].as_object().unwrap() {
        let again = number(&tags[tag]["mean_displacement"]);
        // both equilibria are sought to 1e-10 of the forces
        assert!((again - number(mean)).abs() < 1e-8 * 1e-3, "{tag} {again} {mean}");
    }
}

/// The slopes that `solver check` prints, and the tests that it made.
fn slopes(stdout: &str) -> (Vec<f64>, Vec<&str>) {
    let slope = |l: &str| l.strip_prefix("  slope ")?.split(' ').next()?.parse().ok();
    let named = |l: &&str| l.starts_with('"');
    (stdout.lines().filter_map(slope).collect(), stdout.lines().filter(named).collect())
}

/// Terms that depend on the displacement, or on the shape alone.
fn assert_tested(stdout: &str, directions: &[&str], materials: bool) {
    let (slopes, names) = slopes(stdout);
    assert!(slopes.iter().all(|s| (s - 2.0).abs() < 0.1), "{stdout}");
    for direction in directions {
        for test in ["\"top\" by shape", "\"wall\" by shape", "\"top\" by material.body"] {
            let found = names.contains(&format!("{test}, {direction}").as_str());
            assert_eq!(found, materials || test.ends_with("shape"), "{test}: {stdout}");
        }
    }
    // three terms depend on the shape, one on the material
    assert!(slopes.len() >= 3 * directions.len(), "{stdout}");
}

#[test]
fn gradients_are_exact_at_the_start_and_at_the_design() {
    let (dir, _) = optimized();
    let three = ["gradient", "random 1", "random 2"];
    for (arguments, directions) in [
        ("", &three[..2]),
        // three handles bend the objective more: steps shorter than a tenth of an edge
        ("--design-only --handles 3 --random 2 --motion 3e-4", &three),
        // at the design another side of the chamber is nearest to the wall after longer steps: the barrier has a kink there
        ("--design-only --handles 3 --mesh out/design.msh --random 2 --motion 3e-5", &three),
    ] {
        let run = dir.solver(&format!("check design.toml {arguments}"));
        run.assert_good();
        assert_tested(&run.stdout, directions, arguments.is_empty());
    }
}

/// The same with quadratic elements, whose middle nodes move with the vertices.
#[test]
fn gradients_are_exact_with_quadratic_elements() {
    let dir = chamber::workdir();
    dir.write("design.toml", &dir.text("design.toml").replace("p1.toml", "sim.toml"));
    let run = dir.solver("check design.toml --steps 4");
    run.assert_good();
    assert_tested(&run.stdout, &["gradient", "random 1"], true);
}

/// The check passes where it can measure, and fails where rounding hides what the gradient promises.
#[test]
fn a_motion_lost_in_rounding_fails_the_check() {
    let run =
        chamber::workdir().solver("check design.toml --design-only --handles 2 --motion 1e-11");
    run.assert_refused(1, &["slope is not 2", "cannot be measured"]);
}

#[test]
fn nothing_to_gain_is_no_result() {
    let dir = chamber::workdir();
    dir.write("design.toml", &dir.text("design.toml").replace("iterations = 3", "iterations = 0"));
    dir.solver("optimize design.toml -o out")
        .assert_refused(1, &["design.toml", "no step lowered the objective", "report.json"]);
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
fn arguments_of_the_check() {
    let dir = chamber::workdir();
    let words: &[&str] = &["1000 handles", "33 vertices"];
    dir.solver("check design.toml --handles 1000").assert_refused(2, words);
    dir.solver("check design.toml --steps many").assert_refused(2, &["--steps", "many"]);
    // none of these could give a slope
    for [option, value] in [["--handles", "0"], ["--steps", "1"], ["--motion", "0"]] {
        dir.solver(&format!("check design.toml {option} {value}"))
            .assert_refused(2, &[option, value]);
    }
}

#[test]
fn gauss_newton_is_refused_for_more_variables_than_it_takes() {
    let dir = chamber::workdir();
    let body = chamber::refined(2);
    dir.put("body.msh", &body);
    let free = dir.text("design.toml").replace("handles = 1\n", "vertices = true\n");
    dir.write("design.toml", &free);
    dir.solver("optimize design.toml -o out --set optimizer.method=gauss-newton")
        .assert_refused(2, &["level 1: ", "variables, of which", "at most 400", "l-bfgs"]);
    assert!(!dir.path("out/report.json").exists());
}
