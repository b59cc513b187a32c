//! `castings: volume` fails when the castings are not the body, though each is sound.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::OnceLock;

use crate::fixture::{
    CHAMBER, CLOSED, Scene, assert_fails, assert_status, change_report, copy, stderr, stdout,
};
use fab::plan::report::PlanReport;
use fab::verify::{Against, Line, Status, verify};

/// Two halves of a closed chamber, unequal by the cut below its middle.
const HALVES: &str = "method = \"halves\"
[gluing]
normal = [0, 0, 1]
offset = 0.013";

/// The molds of two halves.
fn halved() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| {
        let scene = Scene::planned(&CLOSED, HALVES);
        scene.made();
        scene
    })
}

/// The lines of a copy of the molds of two halves after `damage`.
fn after_halving(damage: impl FnOnce(&Path)) -> Vec<Line> {
    let scene = halved();
    let folder = tempfile::tempdir().unwrap();
    let mold = folder.path().join("mold");
    std::fs::copy(scene.path("design.msh"), folder.path().join("design.msh")).unwrap();
    copy(&scene.path("mold"), &mold);
    damage(&mold);
    verify(&mold, Against::default()).unwrap()
}

#[test]
fn castings() {
    const CHECK: &str = "castings: volume";
    let lines = after_halving(|_| ());
    assert_status(&lines, CHECK, Status::Ok);
    // One half is forgotten, or cast twice: each mold alone is sound.
    let replan = |mold: &Path, f: fn(&mut PlanReport)| {
        let mut plan = PlanReport::read(mold).unwrap();
        assert_eq!(plan.molds.len(), 2);
        f(&mut plan);
        plan.write(mold).unwrap();
    };
    let others_hold = |lines: &[Line]| {
        let failed = |line: &&Line| line.status == Status::Fail && line.name != CHECK;
        let failed: Vec<&Line> = lines.iter().filter(failed).collect();
        assert!(failed.is_empty(), "{failed:#?}");
    };
    let lines = after_halving(|mold| replan(mold, |plan| drop(plan.molds.pop())));
    assert_fails(&lines, CHECK);
    others_hold(&lines);
    let lines = after_halving(|mold| {
        replan(mold, |plan| plan.molds[1].folder = plan.molds[0].folder.clone());
    });
    assert_fails(&lines, CHECK);
    others_hold(&lines);
    // A half of another body.
    let lines = after_halving(|mold| {
        let below = mold.join(&PlanReport::read(mold).unwrap().molds[1].folder);
        change_report(&below, |report| report.cast.volume *= 1.01);
    });
    assert_fails(&lines, CHECK);
}

/// Walls are those of the body, whatever it is cut into.
#[test]
fn walls_of_what_is_glued() {
    const CHECK: &str = "castings: thinnest wall";
    assert_status(&after_halving(|_| ()), CHECK, Status::Ok);
    // Its thinnest walls have 4 mm.
    let lines = after_halving(|mold| {
        let below = mold.join(&PlanReport::read(mold).unwrap().molds[0].folder);
        change_report(&below, |report| report.casting.least_wall = 4.1e-3);
    });
    assert_fails(&lines, CHECK);
}

#[test]
fn a_simulation_is_that_of_the_body_that_is_cast() {
    let own = halved().verify_inflated(halved().simulation(0.5, true, 1.2).path());
    assert!(own.status.success(), "{}{}", stdout(&own), stderr(&own));
    assert!(stdout(&own).contains("inflated: thinnest wall"), "{}", stdout(&own));
    let other = Scene::planned(&CHAMBER, "").simulation(0.5, true, 1.2);
    let refused = halved().verify_inflated(other.path());
    assert_eq!(refused.status.code(), Some(1), "{}", stderr(&refused));
    let said = stdout(&refused);
    let line = said.lines().find(|line| line.contains("inflated: body")).unwrap();
    assert!(line.starts_with("FAIL") && line.matches("design.msh, sha256 ").count() == 2, "{line}");
    let missing = halved().verify_inflated(Path::new("/nowhere/optimized"));
    assert_eq!(missing.status.code(), Some(2), "{}", stdout(&missing));
    assert!(stderr(&missing).contains("/nowhere/optimized: there is no such folder"));
}
