//! `cast.html`, the sheet for the one who casts, and how checks are listed.

#![allow(clippy::unwrap_used)]

use std::fs;

use crate::fixture::{CHAMBER, Scene, TWO_CHAMBERS};

#[test]
fn one_sheet_has_all_molds_of_a_body() {
    let scene = Scene::planned(&TWO_CHAMBERS, "method = \"halves\"\n");
    scene.made();
    scene.assert_sheet(&[
        "Cast the half-a",
        "Cast the half-b",
        "Put it together",
        "the other half is glued to it, as the last steps say",
        "Method: halves; the plane ",
    ]);
}

#[test]
fn checks_that_hold_are_counted_and_listed_on_demand() {
    let scene = Scene::new(&CHAMBER, "");
    scene.made();
    let verify = |more: &[&str]| scene.run(&[&["verify", "mold"], more].concat()).stdout;
    let all = verify(&["--all"]);
    let folded = verify(&["-o", "checks.txt"]);
    let count = |text: &str, status: &str| text.lines().filter(|l| l.starts_with(status)).count();
    let [held, warned] = ["ok", "warn"].map(|status| count(&all, status));
    assert!(held > 30, "{all}");
    let last = format!("{held} checks hold, {warned} warn, 0 fail");
    assert_eq!(all.lines().last().unwrap(), last);
    assert_eq!(folded.lines().count(), warned + 1, "{folded}");
    assert_eq!(folded.lines().last().unwrap(), last + "; --all lists those that hold");
    let written = fs::read_to_string(scene.path("checks.txt")).unwrap();
    assert_eq!([count(&written, "ok"), written.lines().count()], [held, held + warned]);
    fs::remove_file(scene.path("mold/lower.stl")).unwrap();
    let folded = verify(&[]);
    assert!(folded.starts_with("FAIL") && count(&folded, "FAIL") == 1, "{folded}");
}
