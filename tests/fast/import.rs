//! `solver import`: what is refused, and what is said. That imported scenes are what they were is seen by what they do, in
//! `polyfem.rs`.

use tests::published::FOLDER;
use tests::workdir::Workdir;

#[test]
fn what_cannot_be_imported_leaves_nothing_behind() {
    for (file, words) in [
        (
            "frog/state_frog_quasistatic.json",
            &["state_frog_quasistatic.json", "frog_base_mesh.msh"],
        ),
        ("finger/state_finger.json", &["state_finger.json", "finger_base_mesh.msh"]),
    ] {
        let Some(path) = tests::shared(&format!("{FOLDER}/{file}")) else { return };
        let dir = Workdir::new();
        let run = dir.solver(&format!("import {} -o out", path.display()));
        run.assert_refused(2, words);
        run.assert_refused(2, &["/geometry/0/mesh: there is no file", "put it there"]);
        assert_eq!(dir.files("out"), [""; 0]);
    }
    let dir = Workdir::new();
    for (text, words) in [("{", "bad.json: not JSON"), ("[1]", "bad.json: a list or a value")] {
        dir.write("bad.json", text);
        dir.solver("import bad.json -o out").assert_refused(2, &[words]);
    }
    dir.solver("import absent.json -o out").assert_refused(2, &["absent.json"]);
}

#[test]
fn the_program_warns_and_writes_what_it_says() {
    let Some(path) = tests::shared(&format!("{FOLDER}/walker/state_walker.json")) else { return };
    let dir = Workdir::new();
    let run = dir.solver(&format!("import {} -o out --thickness 0.01", path.display()));
    run.assert_good();
    for words in ["/solver/linear/solver", "0.010000 m thick", "wrote out/sim.toml"] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    let names = ["import.report.json", "sim.toml", "square.msh", "walker.msh"];
    assert_eq!(dir.files("out"), names);
}
