//! Names that are given to make: what make or the shell take for their own is refused, before any rule is
//! read and any shell runs.

use std::process::{Command, Output};

use tests::workdir::{Workdir, repository};

/// Runs make in the checkout, without the flags of a make that runs this test.
fn make(arguments: &[&str]) -> Output {
    let mut command = Command::new("make");
    for flags in ["MAKEFLAGS", "MFLAGS", "MAKELEVEL"] {
        command.env_remove(flags);
    }
    command.args(["--dry-run"]).args(arguments).current_dir(repository()).output().unwrap()
}

#[test]
fn names_with_a_meaning_to_make_or_the_shell_are_refused() {
    let dir = Workdir::new();
    let ran = dir.path("ran").display().to_string();
    let code = format!("$(shell touch {ran})");
    let mut names = vec![code.clone(), format!("`touch {ran}`"), format!("x; touch {ran}")];
    names.extend(["-x", "--file=x", "x ", "x\ny", "x\ty"].map(str::to_owned));
    for c in "$;:*?[]{}()<>&|!'\"`\\~%=^# ".chars() {
        names.push(format!("x{c}y"));
    }
    for name in &names {
        // dry or not, a function of make would run while the rules are read
        let output = make(&["body", &format!("DIR={name}")]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert_eq!(said.lines().count(), 1, "{name}: {said}");
        assert!(said.contains("*** DIR: a name has "), "{name}: {said}");
        assert!(output.stdout.is_empty(), "{name}: nothing is made");
    }
    for variable in ["BODY", "SWEEP", "QUALITY", "RETRY", "TARGET", "PREFIX", "DESTDIR", "PYTHON"] {
        let output = make(&["sweep", &format!("{variable}={code}")]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(&format!("*** {variable}: a name has $ ( )")), "{variable}: {said}");
    }
    assert!(!dir.path("ran").exists());
}

#[test]
fn other_names_are_taken_as_they_are() {
    for name in ["x", "./x/", "x-y_z.1/a,b", "\u{e9}t\u{e9}/x@y", "/tmp/x+y"] {
        let output = make(&["body", &format!("DIR={name}")]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!said.contains("a name has"), "{name}: {said}");
        assert!(
            String::from_utf8(output.stdout).unwrap().contains("there is no model.toml"),
            "{name}"
        );
    }
}
