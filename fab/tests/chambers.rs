//! Bodies with several chambers, each with its own tag, and bodies without one.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CELL, CHAMBER, Cubes, Scene, TWO_CHAMBERS};
use fab::mold::Purpose;
use fab::plan::report::PlanReport;
use mesh::{Tags, topology};

const TUBE: &str = "[fitting]\nname = \"tube-4x2.5\"\n";

/// A scene whose chambers have the tags ch1, ch2, … from left to right, `width` cubes each.
fn scene(body: &Cubes, width: f64, config: &str) -> Scene {
    let scene = Scene::planned(body, config);
    let (mesh, tags) = body.mesh(CELL);
    let mut apart = Tags::new(["seat", "ch1", "skin", "ch2", "ch3"].map(String::from).to_vec());
    for facet in topology::boundary(&mesh).facets {
        let x = facet.iter().map(|&v| mesh.vertices[v].x).sum::<f64>() / 3.0;
        let chamber = [2, 4, 5][((x / CELL / width) as usize).min(2)];
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

/// Cores that can be mixed up, as their stubs are alike, but not turned, as their gaps are narrow; and one that can be turned:
/// a stub of 0.9 mm radius, whose flat takes 0.27 mm, with a gap of 0.2 mm on either side.
#[test]
fn how_cores_can_be_mistaken_is_told() {
    let two = two("method = \"soluble\"\n[core]\nclearance = 1e-4\n[casting]\nleak_test = 2e4\n");
    two.made();
    let report = two.report(".");
    assert_eq!(report.chambers, ["ch2", "ch1"]);
    assert!(report.one_way, "{:?}", report.findings);
    let sockets = report.outlines(Purpose::Socket).count();
    assert_eq!((report.parts.len(), sockets), (4, 2));
    two.assert_sheet(&[
        "its cores can be mixed up: mark",
        "core1 for `ch2` into socket 1 and core2 for `ch1` into socket 2",
        "20.0 kPa for a minute, one chamber after the other",
    ]);
    let turned = Scene::planned(&CHAMBER, "method = \"soluble\"\n[core]\nshoulder = 9e-4\n");
    turned.made();
    assert!(!turned.report(".").one_way);
    turned.assert_sheet(&["its core can be turned"]);
}

/// Chambers that are opened by a plane, with tubes in collars.
#[test]
#[ignore = "many seconds: runs in make test-all"]
fn halves_and_open_chambers_have_several_chambers_and_collars() {
    for method in ["halves", "open-top"] {
        let scene = two(&format!("method = \"{method}\"\n{TUBE}"));
        let said = scene.verified();
        for k in [1, 2] {
            let line = format!("collar {k}: grips 3.60 mm for a tube of 4.00 mm");
            assert!(said.contains(&line), "{line}: {said}");
        }
        assert_eq!(PlanReport::read(&scene.path("mold")).unwrap().molds.len(), 2);
        scene.assert_sheet(&[
            "push it 8 mm into the collar",
            "no bubble may rise",
            "one chamber after",
        ]);
    }
}

#[test]
fn chambers_that_cannot_be_cast_are_refused() {
    for (scene, words) in [
        (
            two("method = \"halves\"\n[gluing]\nnormal = [1, 0, 0]\n"),
            "it does not open 2 of 2 chambers",
        ),
        (
            scene(&TWO_CHAMBERS, 4.5, "chamber = [\"ch1\", \"ch2\", \"ch1\"]"),
            "chamber names \"ch1\" twice",
        ),
        (
            scene(&CHAMBER, 2.5, "chamber = [\"ch1\", \"ch2\"]"),
            "the chambers \"ch1\" and \"ch2\" touch at",
        ),
        (two("method = \"solid\""), "the body has 2 chambers"),
        (Scene::planned(&BLOCK, &format!("chamber = []\n{TUBE}")), "no chamber for a tube"),
    ] {
        scene.refused(2, &[words]);
    }
}

/// A body without a chamber.
const BLOCK: Cubes = Cubes { count: [5, 4, 3], solid: |_| true, chamber: |_| false };

#[test]
fn a_body_without_a_chamber_is_cast() {
    let scene = Scene::planned(&BLOCK, "chamber = []");
    assert_eq!(scene.made().method.name(), "solid");
    let volume = scene.report(".").cast.volume;
    assert!((volume - 60.0 * 64.0).abs() < 1e-6, "{volume}");
    assert!(!scene.sheet().contains("tube") && !scene.sheet().contains("bubble may rise"));
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
    scene.refused(1, &["core would move by ", "mm from mold and other cores then"]);
    // A longer stub leaves enough.
    scene.configure(&format!(
        "{}\n[core]\nlength = 40e-3",
        config("5e-4").replace("core.support = \"stub\"\n", "")
    ));
    scene.made();
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
    let moves = "core1 would move by ";
    open.mold().ended(0, &["another method is tried", moves]);
    let plan = PlanReport::read(&open.path("mold")).unwrap();
    assert_eq!(plan.method.name(), "open-top", "{}", plan.reason);
    assert!(plan.reason.starts_with("the largest flat wall"), "{}", plan.reason);
    assert!(plan.reason.contains(&format!("not pull-out: {moves}")), "{}", plan.reason);
    open.assert_sheet(&[moves]);
    open.verify().good();
    // A plan alone says the same.
    open.plan().good();
    let alone = PlanReport::read(&open.path("plan")).unwrap();
    assert_eq!((alone.method, alone.reason), (plan.method, plan.reason));
    // What was asked for is not replaced.
    open.configure(&format!("method = \"pull-out\"\n{config}"));
    for refused in [open.mold(), open.plan()] {
        refused.ended(1, &[moves]);
    }
}
