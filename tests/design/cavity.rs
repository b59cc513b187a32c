//! The chamber of a block, in a cascade.

use tests::chamber;
use tests::workdir::Workdir;

/// One handle, six, twelve, and then all vertices.
const LEVELS: &str = r#"
[[shape.level]]
handles = 1
iterations = 3

[[shape.level]]
handles = 6
iterations = 4

[[shape.level]]
handles = 12
iterations = 3
"#;

fn with_levels(levels: &str) -> Workdir {
    let dir = chamber::workdir();
    let design = dir.text("design.toml");
    let (head, objectives) = design.split_at(design.find("[[objective]]").unwrap());
    let head = &head[..head.find("[[shape.level]]").unwrap()];
    dir.write("design.toml", &format!("{head}{levels}\n{objectives}"));
    dir
}

fn fall(dir: &Workdir) -> f64 {
    let report = dir.json("out/report.json");
    let of = |key: &str| report[key]["top"].as_f64().unwrap();
    1.0 - of("terms_after") / of("terms_before")
}

#[test]
fn ten_iterations_of_a_cascade_halve_the_distance_to_the_target() {
    let dir = with_levels(LEVELS);
    dir.solver("check design.toml --handles 6 --design-only").assert_good();
    dir.solver("-q optimize design.toml -o out").assert_good();
    assert!(fall(&dir) > 0.5, "{}", fall(&dir));
}

#[test]
fn free_vertices_follow_handles() {
    let dir = with_levels(
        "[[shape.level]]\nhandles = 3\niterations = 2\n\n\
         [[shape.level]]\nvertices = true\niterations = 3\nfirst_step = 0.05\n",
    );
    dir.solver("-q optimize design.toml -o out").assert_good();
    let lines = dir.text("out/history.jsonl");
    assert!(lines.contains("\"level\":2"), "{lines}");
    assert!(fall(&dir) > 0.1, "{}", fall(&dir));
}

/// The check passes where it can measure, and fails where rounding hides what the gradient promises.
#[test]
fn a_motion_lost_in_rounding_fails_the_check() {
    let dir = chamber::workdir();
    let command = "check design.toml --design-only --handles 2";
    dir.solver(command).assert_good();
    let lost = format!("{command} --motion 1e-11");
    dir.solver(&lost).assert_refused(1, &["slope is not 2", "cannot be measured"]);
}
