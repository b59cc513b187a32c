//! The tables of solver/README.md that programs write.

use std::fs;

use tests::workdir::{Workdir, repository};

/// First line of a table: the command that prints it between the dashes.
const BEGIN: &str = "<!-- solver list";
const END: &str = "<!-- end -->";

#[test]
fn tables_are_those_of_the_program() {
    let path = repository().join("solver/README.md");
    let text = fs::read_to_string(&path).unwrap();
    let dir = Workdir::new();
    let (mut current, mut rest, mut count) = (String::new(), &text[..], 0);
    while let Some(begin) = rest.find(BEGIN) {
        let line_end = begin + rest[begin..].find('\n').unwrap();
        let command = rest[begin..line_end].trim_start_matches("<!-- solver ");
        let command = command.trim_end_matches("-->").trim();
        let run = dir.solver(command);
        run.assert_good();
        let end = line_end + rest[line_end..].find(END).expect("every table ends");
        current += &format!("{}\n{}", &rest[..line_end], run.stdout);
        (rest, count) = (&rest[end..], count + 1);
    }
    current += rest;
    assert_eq!(count, 5, "gas laws, sheets, probes, objectives and material laws");
    if current != text {
        let fresh = repository().join("build/solver-README.md");
        fs::create_dir_all(fresh.parent().unwrap()).unwrap();
        fs::write(&fresh, current).unwrap();
        panic!(
            "{} has a table that is not current\n  put in its place: cp {} {}",
            path.display(),
            fresh.display(),
            path.display()
        );
    }
}
