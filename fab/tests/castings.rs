//! `castings: volume` fails when the castings are not the body, though each is sound.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::OnceLock;

use crate::fixture::damaged::after_of;
use crate::fixture::{CHAMBER, CLOSED, Scene, assert_fails, assert_status, change_report};
use fab::files::report::MoldReport;
use fab::plan::report::PlanReport;
use fab::verify::Status;

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

/// Changes the plan of two molds.
fn replan(mold: &Path, f: fn(&mut PlanReport)) {
    let mut plan = PlanReport::read(mold).unwrap();
    assert_eq!(plan.molds.len(), 2);
    f(&mut plan);
    plan.write(mold).unwrap();
}

/// Changes the report of one of them.
fn report_again(mold: &Path, index: usize, f: fn(&mut MoldReport)) {
    let below = mold.join(&PlanReport::read(mold).unwrap().molds[index].folder);
    change_report(&below, f);
}

#[test]
fn castings() {
    let checks = ["castings: volume", "castings: thinnest wall"];
    let sound = after_of(halved(), |_| ());
    checks.iter().for_each(|check| assert_status(&sound, check, Status::Ok));
    // One half is forgotten, or cast twice: each mold alone is sound.
    let plans: [fn(&mut PlanReport); 2] =
        [|plan| drop(plan.molds.pop()), |plan| plan.molds[1].folder = plan.molds[0].folder.clone()];
    for change in plans {
        let lines = after_of(halved(), |mold| replan(mold, change));
        let failed = lines.iter().filter(|line| line.status == Status::Fail);
        assert_eq!(failed.map(|line| line.name.as_str()).collect::<Vec<_>>(), checks[..1]);
    }
    // A half of another body; walls are those of the body, the thinnest of 4 mm, whatever it is cut into.
    let reports: [fn(&mut MoldReport); 2] =
        [|report| report.cast.volume *= 1.01, |report| report.casting.least_wall = 4.1e-3];
    for ((check, index), change) in checks.into_iter().zip([1, 0]).zip(reports) {
        let lines = after_of(halved(), |mold| report_again(mold, index, change));
        assert_fails(&lines, check);
    }
}

#[test]
fn a_simulation_is_that_of_the_body_that_is_cast() {
    let own = halved().verify_inflated(halved().simulation(0.5, true, 1.2).path());
    own.good();
    assert!(own.stdout.contains("inflated: thinnest wall"), "{}", own.stdout);
    let other = Scene::planned(&CHAMBER, "").simulation(0.5, true, 1.2);
    let refused = halved().verify_inflated(other.path());
    refused.ended(1, &[]);
    let line = refused.stdout.lines().find(|line| line.contains("inflated: body")).unwrap();
    assert!(line.starts_with("FAIL") && line.matches("design.msh, sha256 ").count() == 2, "{line}");
    let missing = halved().verify_inflated(Path::new("/nowhere/optimized"));
    missing.ended(2, &["/nowhere/optimized: there is no such folder"]);
}
