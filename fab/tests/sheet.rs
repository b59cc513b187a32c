//! `cast.html`, the sheet for the one who casts, and how checks are listed.

#![allow(clippy::unwrap_used)]

use std::fs;

use crate::fixture::{CHAMBER, Scene, TWO_CHAMBERS, fab, stdout};

#[test]
fn a_sheet_has_parts_masses_and_steps() {
    let scene = Scene::planned(
        &CHAMBER,
        "method = \"soluble\"\n[casting]\nsilicone = \"dragon-skin-20\"\nprinter = \"prusa-mk4\"\n",
    );
    scene.made();
    let cast: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(scene.path("mold/cast.json")).unwrap()).unwrap();
    let grams = format!("{:.1} g", cast["silicone"]["mass_g"].as_f64().unwrap());
    let file = cast["printed"][0]["file"].as_str().unwrap();
    let sheet = scene.sheet();
    scene.assert_sheet(&["Dragon Skin 20", file, &grams, "<h1>design</h1>", "type=\"checkbox\""]);
    assert!(!sheet.contains("<script") && !sheet.contains("src=\"http"), "{sheet}");
}

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
    let [mold, file] = ["mold", "checks.txt"].map(|name| scene.path(name));
    let verify = |more: &[&std::ffi::OsStr]| {
        let command = ["verify".as_ref(), mold.as_os_str()];
        stdout(&fab(&[&command[..], more].concat()))
    };
    let all = verify(&["--all".as_ref()]);
    let folded = verify(&["-o".as_ref(), file.as_os_str()]);
    let count = |text: &str, status: &str| text.lines().filter(|l| l.starts_with(status)).count();
    let [held, warned] = ["ok", "warn"].map(|status| count(&all, status));
    assert!(held > 30, "{all}");
    let last = format!("{held} checks hold, {warned} warn, 0 fail");
    assert_eq!(all.lines().last().unwrap(), last);
    assert_eq!(folded.lines().count(), warned + 1, "{folded}");
    assert_eq!(folded.lines().last().unwrap(), last + "; --all lists those that hold");
    let written = fs::read_to_string(&file).unwrap();
    assert_eq!([count(&written, "ok"), written.lines().count()], [held, held + warned]);
    fs::remove_file(mold.join("lower.stl")).unwrap();
    let folded = verify(&[]);
    assert!(folded.starts_with("FAIL") && count(&folded, "FAIL") == 1, "{folded}");
}
