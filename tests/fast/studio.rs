//! `puffer studio` through HTTP, with the programs as they are now: `tests/python/studio.py`. In a browser it is in
//! `slow/studio.rs`.

use std::os::unix::fs::symlink;
use std::process::Command;

use tests::skip::skip;
use tests::workdir::{Workdir, program, repository};

#[test]
fn a_studio_answers_its_own_page_alone_and_keeps_what_others_wrote() {
    // the standard library is all that it needs
    let young = "import sys; sys.exit(sys.version_info < (3, 10))";
    if !Command::new("python3").args(["-c", young]).status().is_ok_and(|found| found.success()) {
        return skip("python3 is missing, or older than 3.10");
    }
    let dir = Workdir::new();
    symlink(program("cad2fem").parent().unwrap(), dir.put_python().join("bin")).unwrap();
    let mut tests = Command::new("python3");
    tests.arg("-B").arg(repository().join("tests/python/studio.py")).current_dir(dir.path(""));
    let done = tests.env("PYTHONPATH", dir.path("")).output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success() && said.contains("Ran 6 tests"), "{said}");
}
