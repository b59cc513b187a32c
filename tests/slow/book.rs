//! All commands of the book and of the READMEs, those that take minutes, too.

use tests::book::{chapters, readmes};

#[test]
#[ignore = "makes bodies from model to mold, some ten minutes: runs in make test-all"]
fn commands_that_take_minutes_work() {
    let count: usize = chapters().iter().map(|chapter| chapter.run(&["test", "slow"])).sum();
    assert!(count > 200, "{count} lines of commands");
}

#[test]
#[ignore = "makes two bodies from model to mold: runs in make test-all"]
fn commands_of_the_readmes_work() {
    crate::beam(); // they come after `make beam`
    let count: usize = readmes().iter().map(|readme| readme.run(&["slow"])).sum();
    assert!(count > 30, "{count} lines of commands");
}
