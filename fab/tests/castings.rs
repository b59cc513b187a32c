//! `castings: volume` fails when the castings are not the body, though each is sound.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::OnceLock;

use crate::fixture::{CLOSED, Scene, assert_fails, assert_status, change_report, copy, stderr};
use fab::plan::report::PlanReport;
use fab::verify::{Against, Line, Status, verify};

/// Two halves of a closed chamber, unequal by the cut below its middle.
const HALVES: &str = "method = \"halves\"
[gluing]
normal = [0, 0, 1]
offset = 0.013";

/// The lines of a copy of the molds of two halves after `damage`.
fn after_halving(damage: impl FnOnce(&Path)) -> Vec<Line> {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    let scene = SCENE.get_or_init(|| {
        let scene = Scene::planned(&CLOSED, HALVES);
        let output = scene.mold();
        assert!(output.status.success(), "{}", stderr(&output));
        scene
    });
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
