//! `fab mold` and `fab verify` on small bodies.

#![allow(clippy::unwrap_used)]

mod fixture;

use fixture::{CHAMBER, Scene, TWO_TOPS, stderr, stdout};

const PLANE: &str = "[parting]\nkind = \"plane\"\n";
const HEIGHT_FIELD: &str = "[parting]\nkind = \"height-field\"\n";

fn molds_and_verifies(scene: &Scene) -> String {
    let molded = scene.mold();
    assert!(molded.status.success(), "{}", stderr(&molded));
    let verified = scene.verify();
    assert!(verified.status.success(), "{}{}", stdout(&verified), stderr(&verified));
    stdout(&verified)
}

#[test]
fn shells_on_a_base_with_a_planar_parting() {
    let scene = Scene::new(&CHAMBER, PLANE);
    let lines = molds_and_verifies(&scene);
    println!("{lines}");
    for part in ["left", "right", "base", "core"] {
        assert!(scene.path("mold").join(format!("{part}.stl")).exists());
    }
}

#[test]
fn upper_and_lower_shell_with_a_curved_parting() {
    let scene = Scene::new(&CHAMBER, HEIGHT_FIELD);
    let lines = molds_and_verifies(&scene);
    println!("{lines}");
}

#[test]
fn every_top_gets_a_channel() {
    let scene = Scene::new(&TWO_TOPS, HEIGHT_FIELD);
    let lines = molds_and_verifies(&scene);
    println!("{lines}");
}
