//! All commands of the book, those that take minutes, too.

use tests::book::chapters;

#[test]
#[ignore = "makes bodies from model to mold, some ten minutes: runs in make test-all"]
fn commands_that_take_minutes_work() {
    let count: usize = chapters().iter().map(|chapter| chapter.run(&["test", "slow"])).sum();
    assert!(count > 25, "{count} lines of commands");
}
