//! `solver optimize` and `check` given design problems that they cannot use.

use tests::chamber;

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
