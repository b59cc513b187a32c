//! `fab plan` chooses what can be made, `fab mold` makes it, `fab verify` proves it.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CHAMBER, CLOSED, Cubes, Scene, names};
use fab::body::source::CastPart;
use fab::files::report::MoldReport;
use fab::mold::Purpose;
use fab::plan::report::{ChosenBy, PlanReport};
use mesh::Vec3;

/// A tube of one chamber with an inlet as wide.
const TUBE: Cubes =
    Cubes { count: [5, 5, 8], solid: |_| true, chamber: |[i, j, k]| i == 2 && j == 2 && k < 6 };

/// A chamber without a flat wall that faces anywhere but down: a pyramid of steps.
const PYRAMID: Cubes = Cubes {
    count: [9, 9, 8],
    solid: |_| true,
    chamber: |[i, j, k]| {
        let off = i.abs_diff(4).max(j.abs_diff(4));
        (k < 2 && off == 0) || ((2..5).contains(&k) && off < 5 - k)
    },
};

#[test]
fn a_core_no_wider_than_its_inlet_is_pulled_out() {
    let scene = Scene::planned(&TUBE, "");
    let plan = scene.made();
    assert_eq!((plan.method.name(), plan.chosen_by), ("pull-out", ChosenBy::Measures));
    // Squares of 4 mm both.
    assert!((plan.measures[0].value - 1.0).abs() < 1e-9, "{:?}", plan.measures);
    assert_eq!(plan.molds.len(), 1);
    assert_eq!(plan.molds[0].folder, ".");
}

#[test]
fn a_chamber_with_a_flat_wall_is_cast_open_and_closed_with_a_sheet() {
    let scene = Scene::planned(&CHAMBER, "");
    let plan = scene.made();
    assert_eq!(plan.method.name(), "open-top");
    // Around the room 48 mm, around the inlet 16 mm.
    assert!((plan.measures[0].value - 3.0).abs() < 1e-9, "{:?}", plan.measures);
    assert!((plan.measures[1].value - 1.0).abs() < 0.05, "{:?}", plan.measures);
    let [chamber, sheet] = [0, 1].map(|k| scene.report(&plan.molds[k].folder));
    assert_eq!(names(&chamber), ["cup", "lid"]);
    assert_eq!(names(&sheet), ["tray"]);
    assert!(sheet.open && !chamber.open);
    assert!(matches!(sheet.input.part, CastPart::Below(_)));
    // 181 cubes of 64 mm³, without the 6 µm where they are glued.
    let cast = chamber.cast.volume + sheet.cast.volume;
    assert!((cast - 181.0 * 64.0).abs() < 6e-3 * 20.0 * 28.0, "{cast}");
}

#[test]
fn a_closed_chamber_is_cast_in_halves() {
    let scene = Scene::planned(&CLOSED, "method = \"halves\"");
    let plan = scene.made();
    assert_eq!(plan.chosen_by, ChosenBy::Configuration);
    let halves: Vec<MoldReport> = plan.molds.iter().map(|m| scene.report(&m.folder)).collect();
    assert_eq!(halves.len(), 2);
    // 20 × 28 × 24 mm less a room of 12³.
    let cast: f64 = halves.iter().map(|half| half.cast.volume).sum();
    assert!((cast - (20.0 * 28.0 * 24.0 - 1728.0)).abs() < 1e-6, "{cast}");
    for half in &halves {
        assert_eq!(names(half), ["cup", "lid"]);
        // The lid carries half of the core: the plate alone has the area of the block.
        let size = |k: usize| half.block.max[k] - half.block.min[k];
        let lid = &half.parts[1];
        assert!(lid.volume > size(0) * size(1) * 6.0 - 1500.0, "{}", lid.volume);
        assert_eq!(lid.genus, 4, "four holes for bolts");
    }
}

/// A tube with a neck of one cell between its inlet and its chamber, both of three cells.
const NECKED: Cubes = Cubes {
    count: [7, 7, 9],
    solid: |_| true,
    chamber: |[i, j, k]| {
        let off = i.abs_diff(3).max(j.abs_diff(3));
        k < 7 && off < if k == 3 { 1 } else { 2 }
    },
};

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn a_neck_behind_the_inlet_is_judged_as_the_inlet_is() {
    let neck = "48.0 mm around where it passes through a neck of 16.0 mm";
    let words = [neck, "behind its inlet: the neck must stretch to 3.00 times its girth"];
    Scene::planned(&NECKED, "method = \"pull-out\"").refused(2, &words);
    let scene = Scene::planned(
        &NECKED,
        "method = \"pull-out\"\n[limits]\ngirth = 3.01\n[core]\nsupport = \"stub\"",
    );
    let said = scene.verified();
    let plan = PlanReport::read(&scene.path("mold")).unwrap();
    assert!((plan.measures[0].value - 3.0).abs() < 1e-6, "{:?}", plan.measures);
    assert!(said.contains("3.00 × a neck's girth of 16.0 mm"), "{said}");
}

/// The chamber with a core that dissolves, with what `[core]` says.
fn pinned(core: &str, sprue: &str) -> Scene {
    let parting = "[parting]\nkind = \"height-field\"\npull = [0, 0, 1]";
    Scene::planned(
        &CHAMBER,
        &format!("method = \"soluble\"\n[core]\n{core}\n[sprue]\n{sprue}\n{parting}"),
    )
}

#[test]
fn a_core_that_leans_is_held_by_pins_unless_they_are_forbidden() {
    let sprue = "at = [0.002, 0.002, 0.024]";
    let scene = pinned("", sprue);
    scene.verified();
    let held = scene.report(".");
    let hold = &held.holds[0];
    assert!(hold.alone > 0.5 && hold.held <= 0.5, "{hold:?}");
    let pins = |report: &MoldReport| report.outlines(Purpose::Pin).cloned().collect::<Vec<_>>();
    assert_eq!(pins(&held).len(), hold.lengths.len());
    scene.assert_sheet(&["of 2.0 mm diameter"]);

    let scene = pinned("support = \"stub\"", sprue);
    scene.made();
    let stub = scene.report(".");
    assert!(pins(&stub).is_empty() && stub.holds[0].held == stub.holds[0].alone);
    assert!(stub.findings.iter().any(|note| note.rule == "core support"), "{:?}", stub.findings);

    // The core's top is 12 x 12 mm, and 4 mm below the skin.
    let scene = pinned("pins = [[0.007, 0.017, 0.024]]", sprue);
    scene.verified();
    let [pin] = &pins(&scene.report("."))[..] else { panic!("one pin") };
    // The mold's origin lies below the middle of the body.
    let off = Vec3::from(pin.base).xy() - Vec3::new(-3.0, 3.0, 0.0).xy();
    assert!(off.norm() <= 1.0, "{pin:?}");
    assert!((Vec3::from(pin.axis).norm() - 1.0 - 4.0 - 1.5).abs() < 1e-6, "{pin:?}");
}

#[test]
fn what_has_no_flat_wall_and_a_narrow_inlet_gets_a_core_that_dissolves() {
    let scene = Scene::planned(&PYRAMID, "[limits]\nflat = 0.99");
    let plan = scene.made();
    assert_eq!(plan.method.name(), "soluble");
    assert!(scene.report(".").outlines(Purpose::Drain).next().is_some());
}

#[test]
fn an_inlet_too_narrow_for_a_stub_is_no_way_in() {
    // Stubs of 0.56 mm fill less than half of their sockets.
    let config = "[core]\nshoulder = 1.24e-3";
    let plan = Scene::planned(&CHAMBER, config).made();
    assert!(["open-top", "halves"].contains(&plan.method.name()), "{:?}", plan.method);
    assert!(plan.reason.contains("at least 2.073 mm"), "{}", plan.reason);
}

#[test]
fn a_core_may_stretch_its_inlet_as_far_as_is_asked() {
    let scene = Scene::planned(&CHAMBER, "method = \"pull-out\"\n[limits]\ngirth = 3.01");
    assert_eq!(scene.made().method.name(), "pull-out");
}

/// A spool with a chamber: discs of 36 mm on a stem of 12 mm, which lock every shell
/// that is pulled along the axis.
const SPOOL: Cubes = Cubes {
    count: [9, 9, 9],
    solid: |[i, j, k]| !(3..6).contains(&k) || (i.abs_diff(4) < 2 && j.abs_diff(4) < 2),
    chamber: |[i, j, k]| i == 4 && j == 4 && k < 7,
};

#[test]
fn an_undercut_that_does_not_peel_is_refused_and_another_pull_found() {
    let locked =
        "[limits]\npeel = 0.3\n[parting]\nkind = \"plane\"\npull = [0, 0, 1]\noffset = 0.018";
    // 12 mm below both sides of discs that are 36 mm wide, to half a column.
    let words = ["cannot be peeled out", "of its width of 36.00 mm", "limits.peel is 0.30"];
    Scene::planned(&SPOOL, locked).refused(2, &words);
    let scene = Scene::planned(&SPOOL, "[limits]\npeel = 0.3");
    let plan = scene.made();
    let best = plan.directions.iter().find(|d| d.usable).unwrap();
    assert!(best.pull[2].abs() < 1e-9, "{best:?}");
    assert!(best.undercut < 1.0, "{best:?}");
}

/// The chamber is 12 mm wide, its inlet 4 mm.
#[test]
fn a_core_that_is_too_thin_is_refused_with_its_place() {
    let soluble = "method = \"soluble\"\ncasting.least_core = ";
    let scene = Scene::new(&CHAMBER, &format!("{soluble}4.1e-3"));
    let words = "the core of \"cavity\" is 4.000 mm thick at (";
    scene.refused(2, &[words, "casting.least_core is 4.100 mm"]);
    // The plan accepts it, but the stub does not fill the inlet.
    scene.configure(&format!("{soluble}3.9e-3"));
    scene.plan().good();
    scene.refused(1, &["core: thinnest"]);
    scene.configure(&format!("{soluble}1e-3"));
    let lines = scene.verified();
    assert!(lines.contains("core: thinnest"), "{lines}");
}

#[test]
fn the_plan_alone_writes_the_plan_and_its_picture() {
    let scene = Scene::planned(&CHAMBER, "");
    scene.run(&["plan", "design.msh", "-o", "planned"]).good();
    let out = scene.path("planned");
    let plan = PlanReport::read(&out).unwrap();
    assert!(plan.directions.len() > 60);
    assert!(plan.directions.is_sorted_by(|a, b| a.undercut <= b.undercut));
    assert_eq!(plan.method.name(), "open-top");
    assert!(plan.reason.starts_with("the largest flat wall"), "{}", plan.reason);
    assert!(plan.reason.contains("; not pull-out: the core is"), "{}", plan.reason);
    assert!(plan.reason.contains("the plane z = 20.00 mm"), "{}", plan.reason);
    let picture = std::fs::read(out.join("undercut.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 2);
    scene.plan().good();
    assert_eq!(std::fs::read_dir(scene.path("plan")).unwrap().count(), 1, "the plan alone");
}

#[test]
fn the_hull_saves_plastic_and_shrinkage_enlarges_the_mold() {
    let volumes = |config: &str| {
        let scene = Scene::new(&CHAMBER, &format!("{config}\n[core]\nsupport = \"stub\""));
        scene.made();
        let report = scene.report(".");
        let plastic: f64 = report.parts.iter().map(|part| part.volume).sum();
        (plastic, report.plastic_saved, report.cast.volume)
    };
    let (hull, saved, cast) = volumes("labels = false");
    let (block, none, _) = volumes("labels = false\noutside = \"box\"");
    assert_eq!(none, 0.0);
    assert!((block - hull - saved).abs() < 0.01 * saved, "{block} {hull} {saved}");
    let (_, _, larger) = volumes("labels = false\nshrinkage = 0.01");
    assert!((larger / cast - 0.99_f64.powi(-3)).abs() < 1e-6, "{}", larger / cast);
}

#[test]
fn values_are_set_from_outside() {
    let scene = Scene::new(&TUBE, "");
    let plan = ["plan", "design.msh", "-o", "mold", "--no-pictures"];
    let asked = [&plan[..], &["--config", "mold.toml", "--set", "method=pull-out"]].concat();
    scene.run(&asked).good();
    assert_eq!(PlanReport::read(&scene.path("mold")).unwrap().method.name(), "pull-out");
    for (given, more, words) in [
        (&asked[..], "limits.girth=0.9", "limits.girth is 0.90"),
        (&asked, "limits.grith=2", "girth"),
        (&plan, "wall=4e-3", "name it with --config"),
    ] {
        scene.run(&[given, &["--set", more]].concat()).ended(2, &[words]);
    }
}
