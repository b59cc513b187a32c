//! All commands of the book and of the README, those that take minutes, too.

use tests::book::{chapters, readme};

#[test]
#[ignore = "makes bodies from model to mold, some ten minutes: runs in make test-all"]
fn commands_that_take_minutes_work() {
    let count: usize = chapters().iter().map(|chapter| chapter.run(&["test", "slow"])).sum();
    assert!(count > 25, "{count} lines of commands");
}

#[test]
#[ignore = "makes two bodies from model to mold: runs in make test-all"]
fn commands_of_the_readme_work() {
    let count = readme().run(&["slow"]);
    assert!(count > 9, "{count} lines of commands");
}
