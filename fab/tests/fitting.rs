//! Collars for tubes and bolts of the base: made, and found in the files.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CHAMBER, CLOSED, Scene, stderr, stdout};
use fab::files::report::MoldReport;
use serde_json::Value;

const PLANE: &str = "[parting]\nkind = \"plane\"\npull = [0, 1, 0]\n";
const TUBE: &str = "[fitting]\nname = \"tube-4x2.5\"\n";

/// What `fab verify` prints for a mold that it accepts.
fn verified(scene: &Scene) -> String {
    let molded = scene.mold();
    assert!(molded.status.success(), "{}", stderr(&molded));
    let verified = scene.verify();
    assert!(verified.status.success(), "{}{}", stdout(&verified), stderr(&verified));
    stdout(&verified)
}

fn add(value: &mut Value, change: f64) {
    *value = serde_json::json!(value.as_f64().unwrap() + change);
}

/// Whether `fab verify` rejects a mold with the check that `spoil` names, when it has changed
/// mold.json; the mold is left as it was.
fn assert_fails(scene: &Scene, spoil: impl FnOnce(&mut Value) -> String) {
    let path = scene.path("mold/mold.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut report = serde_json::from_str(&text).unwrap();
    let line = spoil(&mut report);
    std::fs::write(&path, report.to_string()).unwrap();
    let said = stdout(&scene.verify());
    let failed = |l: &&str| l.starts_with("FAIL") && l.contains(&line);
    assert!(said.lines().any(|l| failed(&l)), "{line}: {said}");
    std::fs::write(&path, text).unwrap();
}

/// Moves the first channel or gap of a purpose along an axis [mm].
fn shift(report: &mut Value, purpose: &str, axis: usize, by: f64) {
    let features = report["features"].as_array_mut().unwrap();
    let feature = features.iter_mut().find(|f| f["purpose"] == purpose).unwrap();
    add(&mut feature["base"][axis], by);
}

/// A collar is cast with the chamber, and `fab verify` and the sheet say so.
fn assert_collar(scene: &Scene, said: &str) {
    assert!(said.contains("3.60 mm for a tube of 4.00 mm, 10.0 %"), "{said}");
    let report = MoldReport::read(&scene.path("mold")).unwrap();
    // A ring 8 mm long beside the inlet of 4 × 4 mm, whose corners are 2.83 mm from its
    // middle and covered by 1 mm: outside 3.83 mm, bore 1.8 mm.
    let pi = std::f64::consts::PI;
    let (outside, bore) = (8.0_f64.sqrt() + 1.0, 1.8);
    let ring = 8.0 * pi * (outside * outside - bore * bore);
    let added = report.cast.volume - 181.0 * 64.0;
    assert!((added / ring - 1.0).abs() < 1e-3, "{added} {ring}");
    let sheet = scene.sheet();
    for words in ["tube of 4 mm, 2.5 mm inside", "push it 8 mm into", "bore of 3.60 mm", "SMC"] {
        assert!(sheet.contains(words), "{words}: {sheet}");
    }
}

#[test]
fn a_collar_is_cast_with_the_body() {
    // No hole of a pin, so that the volume is exact.
    let scene = Scene::new(&CHAMBER, &format!("{TUBE}\n[core]\nsupport = \"stub\""));
    let said = verified(&scene);
    assert_collar(&scene, &said);
}

#[test]
#[ignore = "ten seconds: runs in make test-all"]
fn a_collar_that_was_not_cast_is_noticed() {
    let scene = Scene::new(&CHAMBER, &format!("{TUBE}{PLANE}"));
    verified(&scene);
    let fails = |key: &str, change: f64, line: &str| {
        assert_fails(&scene, |report| {
            add(report.pointer_mut(&format!("/collars/0/{key}")).unwrap(), change);
            line.into()
        });
    };
    fails("radius", 0.02, "surface: design to mold");
    fails("base/2", 0.02, "surface: design to mold");
    // The sheet told another bore.
    fails("bore", 0.02, "cast.json");
    let loose = Scene::new(&CHAMBER, &format!("{TUBE}interference = 0.01\n{PLANE}"));
    let molded = loose.mold();
    assert_eq!(molded.status.code(), Some(1));
    assert!(stderr(&molded).contains("none is written: collar 1: grips"), "{}", stderr(&molded));
}

#[test]
fn tubes_that_do_not_fit_are_refused() {
    for (body, config, message) in [
        (&CLOSED, TUBE.to_owned(), "a chamber is closed"),
        (&CHAMBER, format!("{TUBE}wall = 0.03\n"), "lies on the body with"),
        (&CHAMBER, "[fitting]\nname = \"hose\"".into(), "known are barb-eighth-inch"),
    ] {
        let molded = Scene::new(body, &config).mold();
        let said = stderr(&molded);
        assert_eq!(molded.status.code(), Some(2), "{said}");
        assert!(said.contains(message), "{said:?} does not say {message:?}");
    }
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn sides_are_bolted_to_their_base_beside_a_collar() {
    let scene = Scene::new(&CHAMBER, &format!("{TUBE}{PLANE}\n[core]\nsupport = \"stub\""));
    let said = verified(&scene);
    assert_collar(&scene, &said);
    let joins =
        |who: &str| said.lines().filter(|l| l.contains(": joins") && l.contains(who)).count();
    assert_eq!(joins("left and base"), 2, "{said}");
    assert_eq!(joins("right and base"), 2, "{said}");
    assert!(joins("left and right") >= 2, "{said}");
    assert_fails(&scene, |report| {
        shift(report, "bolt", 0, 1.0);
        "bolt 1: joins".into()
    });
}
