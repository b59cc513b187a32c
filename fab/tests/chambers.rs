//! Bodies with several chambers, each with its own tag, and bodies without one.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CHAMBER, Cubes, Scene, TWO_CHAMBERS, change_report, stderr, stdout};
use fab::files::report::MoldReport;
use fab::files::sheet::Sheet;
use fab::plan::report::PlanReport;
use mesh::{Tags, topology};

const TUBE: &str = "[fitting]\nname = \"tube-4x2.5\"\n";

/// A scene whose chambers have the tags ch1, ch2, … from left to right, `width` cubes each.
fn scene(body: &Cubes, width: f64, config: &str) -> Scene {
    let scene = Scene::planned(body, config);
    let (mesh, tags) = body.mesh();
    let mut apart = Tags::new(["seat", "ch1", "skin", "ch2", "ch3"].map(String::from).to_vec());
    for facet in topology::boundary(&mesh).facets {
        let x = facet.iter().map(|&v| mesh.vertices[v].x).sum::<f64>() / 3.0;
        let chamber = [2, 4, 5][((x / crate::fixture::CELL / width) as usize).min(2)];
        let id = tags.get(facet).unwrap();
        apart.set(facet, if id == 2 { chamber } else { id });
    }
    mesh::io::write_tets(&scene.path("design.msh"), &mesh, &apart).unwrap();
    scene
}

/// Two chambers as `config` asks; ch2 comes first.
fn two(config: &str) -> Scene {
    scene(&TWO_CHAMBERS, 4.5, &format!("chamber = [\"ch2\", \"ch1\"]\n{config}"))
}

/// What `fab verify` says of the mold of a scene, which it accepts.
fn verified(scene: &Scene) -> String {
    let molded = scene.mold();
    assert!(molded.status.success(), "{}", stderr(&molded));
    let verified = scene.verify();
    assert!(verified.status.success(), "{}{}", stdout(&verified), stderr(&verified));
    stdout(&verified)
}

fn refused(scene: &Scene) -> String {
    let molded = scene.mold();
    assert_eq!(molded.status.code(), Some(2), "{}", stderr(&molded));
    stderr(&molded)
}

/// The status and the number of millimetres of a check.
fn proud(said: &str, check: &str) -> (String, f64) {
    let line = said.lines().find(|line| line.contains(check)).unwrap();
    let number = line.split_once("stands ").unwrap().1.split(' ').next().unwrap();
    (line[..4].trim().into(), number.parse().unwrap())
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn cores_that_can_be_mixed_up_are_told() {
    let scene = two("method = \"soluble\"\n[casting]\nleak_test = 2e4\n");
    let said = verified(&scene);
    let report = MoldReport::read(&scene.path("mold")).unwrap();
    assert_eq!(report.chambers, ["ch2", "ch1"]);
    assert!(report.one_way, "{:?}", report.findings);
    for core in ["core1", "core2"] {
        assert_eq!(proud(&said, &format!("{core}: one way only")).0, "ok");
    }
    for words in [
        "its cores can be mixed up",
        "core1 for `ch2` into socket 1 and core2 for `ch1` into socket 2",
        "20.0 kPa for a minute, one chamber after the other",
    ] {
        assert!(scene.sheet().contains(words), "{words}: {}", scene.sheet());
    }
}

#[test]
fn a_core_that_can_be_turned_is_told() {
    // A stub of 0.9 mm radius: its flat takes 0.27 mm, its gap is 0.2 mm on either side.
    let scene = Scene::planned(&CHAMBER, "method = \"soluble\"\n[core]\nshoulder = 9e-4\n");
    let said = verified(&scene);
    assert_eq!(proud(&said, "core: one way only").0, "warn");
    assert!(scene.sheet().contains("its core can be turned"), "{}", scene.sheet());
    // A mold that says otherwise is found to be wrong.
    let mold = scene.path("mold");
    change_report(&mold, |report| report.one_way = true);
    Sheet::new(&MoldReport::read(&mold).unwrap()).unwrap().write(&mold).unwrap();
    let said = stdout(&scene.verify());
    assert!(said.contains("FAIL  core: one way only"), "{said}");
}

/// Chambers that are opened by a plane, with tubes in collars.
fn glued(method: &str, config: &str) {
    let scene = two(&format!("method = \"{method}\"\n{config}{TUBE}"));
    let said = verified(&scene);
    for k in [1, 2] {
        let line = said.lines().find(|line| line.contains(&format!("collar {k}: grips")));
        let line = line.unwrap_or_else(|| panic!("{said}"));
        assert!(line.contains("3.60 mm for a tube of 4.00 mm"), "{line}");
    }
    let plan = PlanReport::read(&scene.path("mold")).unwrap();
    assert_eq!(plan.molds.len(), 2);
    for words in ["push it 8 mm into the collar", "no bubble may rise", "one chamber after"] {
        assert!(scene.sheet().contains(words), "{words}: {}", scene.sheet());
    }
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn halves_have_several_chambers_and_collars() {
    glued("halves", "");
}

#[test]
#[ignore = "as halves: runs in make test-all"]
fn open_chambers_have_collars() {
    glued("open-top", "");
}

#[test]
fn chambers_that_no_plate_can_carry_are_refused() {
    let said = refused(&two("method = \"halves\"\n[gluing]\nnormal = [1, 0, 0]\n"));
    assert!(said.contains("it does not open 2 of 2 chambers"), "{said}");
    // The left chamber's wall at x = 4 mm is flat, but the right one is not open there.
    let said = refused(&scene(&TWO_CHAMBERS, 4.5, "chamber = [\"ch1\", \"ch2\", \"ch1\"]"));
    assert!(said.contains("chamber names \"ch1\" twice"), "{said}");
    let said = refused(&scene(&CHAMBER, 2.5, "chamber = [\"ch1\", \"ch2\"]"));
    assert!(said.contains("the chambers \"ch1\" and \"ch2\" touch at"), "{said}");
    let said = refused(&two("method = \"solid\""));
    assert!(said.contains("the body has 2 chambers"), "{said}");
}

#[test]
fn a_body_without_a_chamber_is_cast() {
    const BLOCK: Cubes = Cubes { count: [5, 4, 3], solid: |_| true, chamber: |_| false };
    let scene = Scene::planned(&BLOCK, "chamber = []");
    verified(&scene);
    let plan = PlanReport::read(&scene.path("mold")).unwrap();
    assert_eq!(plan.method.name(), "solid");
    let report = MoldReport::read(&scene.path("mold")).unwrap();
    assert!((report.cast.volume - 60.0 * 64.0).abs() < 1e-6, "{}", report.cast.volume);
    assert!(!scene.sheet().contains("tube") && !scene.sheet().contains("bubble may rise"));
    let said = refused(&Scene::planned(&BLOCK, &format!("chamber = []\n{TUBE}")));
    assert!(said.contains("no chamber for a tube"), "{said}");
}

/// A core of 4 × 4 × 64 mm on a stub of 8 mm leans by millimetres in silicone of 4 mm, and no pin may hold it.
#[test]
fn a_core_that_would_come_near_the_mold_fails() {
    let tall = Cubes {
        count: [3, 3, 17],
        solid: |_| true,
        chamber: |[i, j, k]| i == 1 && j == 1 && k < 16,
    };
    let config = |least: &str| {
        format!("method = \"soluble\"\ncore.support = \"stub\"\ncasting.least_wall = {least}")
    };
    let scene = Scene::new(&tall, &config("3e-3"));
    let made = scene.mold();
    assert_eq!(made.status.code(), Some(1), "{}", stderr(&made));
    assert!(stderr(&made).contains("core: stays is "), "{}", stderr(&made));
    assert!(stderr(&made).contains("mm from mold and other cores then"), "{}", stderr(&made));
    // A longer stub leaves enough.
    scene.configure(&format!(
        "{}\n[core]\nlength = 40e-3",
        config("5e-4").replace("core.support = \"stub\"\n", "")
    ));
    let made = scene.mold();
    assert!(made.status.success(), "{}", stderr(&made));
}

/// Two cores of 4 × 4 × 64 mm that stubs do not hold: they are pulled out where that is asked for, and then the mold
/// is refused; else the chambers are cast on a plate.
#[test]
#[ignore = "many seconds: runs in make test-all"]
fn another_method_is_chosen_where_cores_would_lean() {
    let tall = Cubes {
        count: [5, 3, 17],
        solid: |_| true,
        chamber: |[i, j, k]| (i == 1 || i == 3) && j == 1 && k < 16,
    };
    let config =
        "chamber = [\"ch1\", \"ch2\"]\ncore.support = \"stub\"\ncasting.least_wall = 3e-3\n";
    let open = scene(&tall, 2.5, config);
    let made = open.mold();
    assert!(made.status.success(), "{}", stderr(&made));
    let moves = "core1 would move by ";
    assert!(stderr(&made).contains("another method is tried"), "{}", stderr(&made));
    assert!(stderr(&made).contains(moves), "{}", stderr(&made));
    let plan = PlanReport::read(&open.path("mold")).unwrap();
    assert_eq!(plan.method.name(), "open-top", "{}", plan.reason);
    assert!(plan.reason.starts_with("the largest flat wall"), "{}", plan.reason);
    assert!(plan.reason.contains(&format!("not pull-out: {moves}")), "{}", plan.reason);
    assert!(open.sheet().contains(moves), "{}", open.sheet());
    assert!(open.verify().status.success());
    // A plan alone says the same.
    let planned = open.plan();
    assert!(planned.status.success(), "{}", stderr(&planned));
    let alone = PlanReport::read(&open.path("plan")).unwrap();
    assert_eq!((alone.method, alone.reason), (plan.method, plan.reason));
    // What was asked for is not replaced.
    open.configure(&format!("method = \"pull-out\"\n{config}"));
    for refused in [open.mold(), open.plan()] {
        assert_eq!(refused.status.code(), Some(1), "{}", stderr(&refused));
        assert!(stderr(&refused).contains("core1: stays is "), "{}", stderr(&refused));
    }
}
