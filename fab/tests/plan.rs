//! `fab plan` chooses what can be made, `fab mold` makes it, `fab verify` proves it.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CHAMBER, CLOSED, Cubes, Scene, fab, stderr, stdout};
use fab::body::source::CastPart;
use fab::files::report::MoldReport;
use fab::mold::Purpose;
use fab::plan::pull::plane;
use fab::plan::report::{ChosenBy, Material, PlanReport};
use mesh::Vec3;
use mesh::solid::Solid;

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

/// The plan of a mold that is written: the checks of `fab verify` hold for its surfaces.
fn made(scene: &Scene) -> PlanReport {
    let made = scene.mold();
    assert!(made.status.success(), "{}", stderr(&made));
    PlanReport::read(&scene.path("mold")).unwrap()
}

/// The plan of a mold; what `fab verify` says of its files.
fn proved(scene: &Scene) -> (PlanReport, String) {
    let plan = made(scene);
    let verified = scene.verify();
    assert!(verified.status.success(), "{}{}", stdout(&verified), stderr(&verified));
    (plan, stdout(&verified))
}

/// The plan of a mold whose files hold the checks of `fab verify`.
fn molded(scene: &Scene) -> PlanReport {
    proved(scene).0
}

fn report(scene: &Scene, folder: &str) -> MoldReport {
    MoldReport::read(&scene.path("mold").join(folder)).unwrap()
}

fn names(report: &MoldReport) -> Vec<&str> {
    report.parts.iter().map(|part| part.name.as_str()).collect()
}

fn refused(scene: &Scene) -> String {
    let output = scene.mold();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(!scene.path("mold/plan.json").exists());
    said
}

#[test]
fn a_core_no_wider_than_its_inlet_is_pulled_out() {
    let scene = Scene::planned(&TUBE, "");
    let plan = molded(&scene);
    assert_eq!((plan.method.name(), plan.chosen_by), ("pull-out", ChosenBy::Measures));
    // Squares of 4 mm both.
    assert!((plan.measures[0].value - 1.0).abs() < 1e-9, "{:?}", plan.measures);
    assert_eq!(plan.molds.len(), 1);
    assert_eq!(plan.molds[0].folder, ".");
}

#[test]
fn a_chamber_with_a_flat_wall_is_cast_open_and_closed_with_a_sheet() {
    let scene = Scene::planned(&CHAMBER, "");
    let plan = molded(&scene);
    assert_eq!(plan.method.name(), "open-top");
    // Around the room 48 mm, around the inlet 16 mm.
    assert!((plan.measures[0].value - 3.0).abs() < 1e-9, "{:?}", plan.measures);
    assert!((plan.measures[1].value - 1.0).abs() < 0.05, "{:?}", plan.measures);
    let [chamber, sheet] = [0, 1].map(|k| report(&scene, &plan.molds[k].folder));
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
    let plan = molded(&scene);
    assert_eq!(plan.chosen_by, ChosenBy::Configuration);
    let halves: Vec<MoldReport> = plan.molds.iter().map(|m| report(&scene, &m.folder)).collect();
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

/// Cut surfaces that are not along coordinate planes differ in the last bits between body,
/// filled body and core.
fn glued_across(normal: &str) -> Scene {
    let config = format!("method = \"halves\"\n[limits]\npeel = 5\n[gluing]\nnormal = {normal}");
    let scene = Scene::planned(&CLOSED, &config);
    assert_eq!(made(&scene).molds.len(), 2, "{normal}");
    scene
}

#[test]
fn halves_are_glued_across_an_oblique_plane() {
    glued_across("[-2, 1, 0.3]");
}

#[test]
#[ignore = "takes tens of seconds: runs in make test-all"]
fn halves_are_glued_across_any_plane() {
    for normal in ["[-2, 1, 0.3]", "[0, 1, 2]", "[0.1, -1, 0.2]"] {
        let verified = glued_across(normal).verify();
        assert!(verified.status.success(), "{normal}: {}", stdout(&verified));
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
    let said = refused(&Scene::planned(&NECKED, "method = \"pull-out\""));
    let neck = "48.0 mm around where it passes through a neck of 16.0 mm";
    for part in [neck, "behind its inlet: the neck must stretch to 3.00 times its girth"] {
        assert!(said.contains(part), "{said:?} does not say {part:?}");
    }
    let scene = Scene::planned(
        &NECKED,
        "method = \"pull-out\"\n[limits]\ngirth = 3.01\n[core]\nsupport = \"stub\"",
    );
    let (plan, said) = proved(&scene);
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
    proved(&scene);
    let held = report(&scene, ".");
    let hold = &held.holds[0];
    assert!(hold.alone > 0.5 && hold.held <= 0.5, "{hold:?}");
    let pins = |report: &MoldReport| {
        report.features.iter().filter(|f| f.purpose == Purpose::Pin).cloned().collect::<Vec<_>>()
    };
    assert_eq!(pins(&held).len(), hold.lengths.len());
    let sheet = scene.sheet();
    assert!(sheet.contains("of 2.0 mm diameter"), "{sheet}");

    let scene = pinned("support = \"stub\"", sprue);
    molded(&scene);
    let stub = report(&scene, ".");
    assert!(pins(&stub).is_empty() && stub.holds[0].held == stub.holds[0].alone);
    assert!(stub.findings.iter().any(|note| note.rule == "core support"), "{:?}", stub.findings);

    // The core's top is 12 x 12 mm, and 4 mm below the skin.
    let scene = pinned("pins = [[0.007, 0.017, 0.024]]", sprue);
    proved(&scene);
    let [pin] = &pins(&report(&scene, "."))[..] else { panic!("one pin") };
    // The mold's origin lies below the middle of the body.
    let off = Vec3::from(pin.base).xy() - Vec3::new(-3.0, 3.0, 0.0).xy();
    assert!(off.norm() <= 1.0, "{pin:?}");
    assert!((Vec3::from(pin.axis).norm() - 1.0 - 4.0 - 1.5).abs() < 1e-6, "{pin:?}");
}

#[test]
fn pins_that_have_no_place_are_refused() {
    let said = refused(&pinned("pins = [[0.007, 0.017, 0.024]]\npin = 5.5e-3", ""));
    let parts =
        ["no pin of 5.50 mm radius", "within 22.0 mm of (0.007, 0.017", "too near to sprue"];
    for part in parts {
        assert!(said.contains(part), "{said:?} does not say {part:?}");
    }
    let said = refused(&pinned("support = \"pin\"\npin = 5.5e-3", ""));
    assert!(said.contains("finds room at the core"), "{said}");
}

#[test]
fn what_has_no_flat_wall_and_a_narrow_inlet_gets_a_core_that_dissolves() {
    let scene = Scene::planned(&PYRAMID, "[limits]\nflat = 0.99");
    let plan = molded(&scene);
    assert_eq!(plan.method.name(), "soluble");
    let drains = report(&scene, ".").features;
    assert!(drains.iter().any(|f| f.purpose == Purpose::Drain));
}

#[test]
#[ignore = "many seconds: runs in make test-all"]
fn a_core_of_wax_has_a_mold_of_its_own() {
    let scene = Scene::planned(&PYRAMID, "method = \"wax\"");
    let plan = molded(&scene);
    assert_eq!(plan.molds.len(), 2);
    assert_eq!(plan.molds[0].casts, Material::Wax);
    let [wax, body] = [0, 1].map(|k| report(&scene, &plan.molds[k].folder));
    assert_eq!(wax.input.part, CastPart::Core);
    let core = body.parts.iter().find(|part| part.name == "core").unwrap();
    assert!((wax.cast.volume / core.volume - 1.0).abs() < 1e-6);
    // Another plan in the same folder leaves nothing of this one.
    scene.configure("method = \"soluble\"");
    made(&scene);
    assert!(!scene.path("mold/core-mold/mold.json").exists());
}

#[test]
fn a_wrong_choice_is_refused_with_what_was_measured() {
    let said = refused(&Scene::planned(&CHAMBER, "method = \"pull-out\""));
    for part in
        ["the core is 48.0 mm around, its inlet 16.0 mm", "to 3.00 times its girth", "possible are"]
    {
        assert!(said.contains(part), "{said:?} does not say {part:?}");
    }
    let said = refused(&Scene::planned(&CLOSED, "method = \"soluble\""));
    assert!(said.contains("a chamber of 1728.0 mm³ is closed"), "{said}");
    assert!(said.contains("\"halves\""), "{said}");
    let said = refused(&Scene::planned(&CHAMBER, "method = \"glue\""));
    assert!(said.contains("unknown variant `glue`") && said.contains("`pull-out`"), "{said}");
    // A method that can be used is used.
    scene_with_looser_limit();
}

fn scene_with_looser_limit() {
    let scene = Scene::planned(&CHAMBER, "method = \"pull-out\"\n[limits]\ngirth = 3.01");
    assert_eq!(made(&scene).method.name(), "pull-out");
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
    let said = refused(&Scene::planned(&SPOOL, locked));
    // 12 mm below both sides of discs that are 36 mm wide, to half a column.
    for part in ["cannot be peeled out", "of its width of 36.00 mm", "limits.peel is 0.30"] {
        assert!(said.contains(part), "{said:?} does not say {part:?}");
    }
    let scene = Scene::planned(&SPOOL, "[limits]\npeel = 0.3");
    let plan = molded(&scene);
    let best = plan.directions.iter().find(|d| d.usable).unwrap();
    assert!(best.pull[2].abs() < 1e-9, "{best:?}");
    assert!(best.undercut < 1.0, "{best:?}");
}

/// The chamber is 12 mm wide, its inlet 4 mm.
#[test]
fn a_core_that_is_too_thin_is_refused_with_its_place() {
    let soluble = "method = \"soluble\"\ncasting.least_core = ";
    let scene = Scene::new(&CHAMBER, &format!("{soluble}4.1e-3"));
    let said = refused(&scene);
    let words = "the core of \"cavity\" is 4.000 mm thick at (";
    assert!(said.contains(words) && said.contains("casting.least_core is 4.100 mm"), "{said}");
    // The plan accepts it, but the stub does not fill the inlet.
    scene.configure(&format!("{soluble}3.9e-3"));
    assert!(scene.plan().status.success());
    let output = scene.mold();
    assert!(stderr(&output).contains("core: thinnest"), "{}", stderr(&output));
    scene.configure(&format!("{soluble}1e-3"));
    let (_, lines) = proved(&scene);
    assert!(lines.contains("core: thinnest"), "{lines}");
}

#[test]
fn the_plan_alone_writes_the_plan_and_its_picture() {
    let scene = Scene::planned(&CHAMBER, "");
    let [mesh, out] = ["design.msh", "planned"].map(|n| scene.path(n));
    let output = fab(&["plan".as_ref(), mesh.as_os_str(), "-o".as_ref(), out.as_os_str()]);
    assert!(output.status.success(), "{}", stderr(&output));
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
    let bare = scene.path("bare");
    let [mesh, out] = [mesh.as_os_str(), bare.as_os_str()];
    let output = fab(&["plan".as_ref(), mesh, "-o".as_ref(), out, "--no-pictures".as_ref()]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(std::fs::read_dir(&bare).unwrap().count(), 1, "the plan alone");
}

#[test]
fn shells_do_not_fit_when_one_is_turned() {
    let scene = Scene::new(&CHAMBER, "");
    assert!(scene.mold().status.success());
    let report = report(&scene, ".");
    let read = |name: &str| {
        let part = report.parts.iter().find(|part| part.name == name).unwrap();
        let mut surface = mesh::io::read_surface(&scene.path("mold").join(&part.file)).unwrap();
        for p in &mut surface.vertices {
            let row = |r: [f64; 3]| Vec3::from(r).dot(p);
            *p = Vec3::new(row(part.to_mold[0]), row(part.to_mold[1]), row(part.to_mold[2]));
        }
        surface
    };
    let [upper, lower] = ["upper", "lower"].map(read);
    let solid = |surface| Solid::from_surface(surface).unwrap();
    let clash = |surface| solid(surface).intersection(&solid(&lower)).volume();
    assert!(clash(&upper) < 1e-3, "{}", clash(&upper));
    let mut turned = upper.clone();
    for p in &mut turned.vertices {
        *p = Vec3::new(-p.x, -p.y, p.z);
    }
    // A cone of 3 mm height, 3 mm radius below and 1.5 mm above, π·3·(9 + 4.5 + 2.25)/3 mm³,
    // less what the slot in that corner takes of it.
    let cone = std::f64::consts::PI * 15.75;
    assert!(clash(&turned) > 0.5 * cone, "{}", clash(&turned));
}

#[test]
fn the_hull_saves_plastic_and_shrinkage_enlarges_the_mold() {
    let volumes = |config: &str| {
        let scene = Scene::new(&CHAMBER, &format!("{config}\n[core]\nsupport = \"stub\""));
        assert!(scene.mold().status.success());
        let report = report(&scene, ".");
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
    let file = |name| scene.path(name).display().to_string();
    let [mesh, config, out] = ["design.msh", "mold.toml", "mold"].map(file);
    let asked = ["plan", &mesh, "--config", &config, "-o", &out, "--no-pictures"];
    let plan = |more: &[&str]| fab(&[&asked, more].concat());
    let method = |more: &[&str]| {
        let planned = plan(more);
        assert!(planned.status.success(), "{}", stderr(&planned));
        PlanReport::read(&scene.path("mold")).unwrap().method.name()
    };
    assert_eq!(method(&[]), "soluble");
    assert_eq!(method(&["--set", "method=pull-out"]), "pull-out");
    let tight = plan(&["--set", "method=pull-out", "--set", "limits.girth=0.9"]);
    assert_eq!(tight.status.code(), Some(2));
    assert!(stderr(&tight).contains("limits.girth is 0.90"), "{}", stderr(&tight));
    let unknown = plan(&["--set", "limits.grith=2"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(stderr(&unknown).contains("girth"), "{}", stderr(&unknown));
    let nothing = fab(&["plan", &mesh, "-o", &out, "--set", "wall=4e-3"]);
    assert!(stderr(&nothing).contains("name it with --config"), "{}", stderr(&nothing));
}

#[test]
fn planes_are_named_by_the_coordinate_that_they_hold() {
    assert_eq!(plane(&-Vec3::z(), -4e-3), "the plane z = 4.00 mm");
    assert_eq!(plane(&Vec3::x(), 0.0), "the plane x = 0.00 mm");
    let tilted = plane(&Vec3::new(0.6, 0.0, 0.8), 2e-3);
    assert_eq!(tilted, "the plane across (0.600, 0.000, 0.800) at 2.00 mm from the origin");
}
