//! Collars for tubes and bolts of the base: made, and found in the files.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CHAMBER, Scene, assert_fails, change_report};
use fab::files::report::MoldReport;
use fab::mold::Purpose;
use fab::verify::{Against, verify};

const PLANE: &str = "[parting]\nkind = \"plane\"\npull = [0, 1, 0]\n";
const TUBE: &str = "[fitting]\nname = \"tube-4x2.5\"\n";

/// A collar is cast with the chamber, and `fab verify` and the sheet say so.
fn assert_collar(scene: &Scene, said: &str) {
    assert!(said.contains("3.60 mm for a tube of 4.00 mm, 10.0 %"), "{said}");
    let report = scene.report(".");
    // A ring 8 mm long beside the inlet of 4 × 4 mm, whose corners are 2.83 mm from its
    // middle and covered by 1 mm: outside 3.83 mm, bore 1.8 mm.
    let pi = std::f64::consts::PI;
    let (outside, bore) = (8.0_f64.sqrt() + 1.0, 1.8);
    let ring = 8.0 * pi * (outside * outside - bore * bore);
    let added = report.cast.volume - 181.0 * 64.0;
    assert!((added / ring - 1.0).abs() < 1e-3, "{added} {ring}");
    let words = ["tube of 4 mm, 2.5 mm inside", "push it 8 mm into", "bore of 3.60 mm", "SMC"];
    scene.assert_sheet(&words);
}

#[test]
fn a_collar_is_cast_with_the_body() {
    // No hole of a pin, so that the volume is exact.
    let scene = Scene::new(&CHAMBER, &format!("{TUBE}\n[core]\nsupport = \"stub\""));
    assert_collar(&scene, &scene.verified());
}

#[test]
#[ignore = "ten seconds: runs in make test-all"]
fn a_collar_that_was_not_cast_is_noticed() {
    let scene = Scene::new(&CHAMBER, &format!("{TUBE}{PLANE}"));
    scene.made();
    let mold = scene.path("mold");
    let sound = scene.report(".");
    for change in [(|report| report.collars[0].radius += 0.02) as fn(&mut MoldReport), |report| {
        report.collars[0].base[2] += 0.02
    }] {
        change_report(&mold, change);
        assert_fails(&verify(&mold, &Against::default()).unwrap(), "surface: design to mold");
        sound.write(&mold).unwrap();
    }
    let loose = Scene::new(&CHAMBER, &format!("{TUBE}interference = 0.01\n{PLANE}"));
    loose.refused(1, &["none is written: collar 1: grips"]);
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn sides_are_bolted_to_their_base_beside_a_collar() {
    let scene = Scene::new(&CHAMBER, &format!("{TUBE}{PLANE}\n[core]\nsupport = \"stub\""));
    let said = scene.verified();
    assert_collar(&scene, &said);
    let joins =
        |who: &str| said.lines().filter(|l| l.contains(": joins") && l.contains(who)).count();
    assert_eq!(joins("left and base"), 2, "{said}");
    assert_eq!(joins("right and base"), 2, "{said}");
    assert!(joins("left and right") >= 2, "{said}");
    let mold = scene.path("mold");
    change_report(&mold, |report| {
        let bolt = report.features.iter_mut().find(|f| f.purpose == Purpose::Bolt).unwrap();
        bolt.base[0] += 1.0;
    });
    assert_fails(&verify(&mold, &Against::default()).unwrap(), "bolt 1: joins");
}
