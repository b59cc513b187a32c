//! Bodies that are hard to mold: each ends in verified parts or in a clear refusal.

#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::time::Instant;

use crate::fixture::{CELL, CHAMBER, CLOSED, Cubes, Scene, TWO_CHAMBERS, stderr, stdout};
use mesh::Vec3;
use mesh::io::{read_tets, write_tets};
use nalgebra::{Matrix3, Rotation3, Unit};

/// What became of a body.
#[derive(Debug, PartialEq)]
enum Outcome {
    /// Parts, and every check holds.
    Verified,
    /// Parts of which `fab verify` says that they must not be used: the checks that failed.
    Rejected(Vec<String>),
    /// No parts: why.
    Refused(String),
}

fn outcome(scene: &Scene) -> Outcome {
    let molded = scene.mold();
    let said = stderr(&molded);
    assert!(!said.contains("panicked"), "{said}");
    if !molded.status.success() {
        assert!(matches!(molded.status.code(), Some(1 | 2)), "{said}");
        assert!(!scene.path("mold/mold.json").exists(), "a mold was left behind");
        return Outcome::Refused(said);
    }
    let verified = scene.verify();
    let said = stdout(&verified);
    assert!(!stderr(&verified).contains("panicked"), "{}", stderr(&verified));
    match verified.status.code() {
        Some(0) => Outcome::Verified,
        Some(1) => Outcome::Rejected(
            said.lines().filter(|l| l.starts_with("FAIL")).map(str::to_owned).collect(),
        ),
        code => panic!("exit code {code:?}: {}", stderr(&verified)),
    }
}

/// A scene whose body is bent after it was made of cubes.
fn bent(body: &Cubes, config: &str, bend: impl FnMut(&mut Vec3)) -> Scene {
    moved(Scene::new(body, config), bend)
}

/// A scene whose vertices are moved.
fn moved(scene: Scene, bend: impl FnMut(&mut Vec3)) -> Scene {
    let path = scene.path("design.msh");
    let mut msh = read_tets(&path).unwrap();
    msh.mesh.vertices.iter_mut().for_each(bend);
    write_tets(&path, &msh.mesh, &msh.tags).unwrap();
    scene
}

/// Distance from the middle of a square of 9 cells, in cells.
fn ring([i, j, _]: [usize; 3]) -> usize {
    i.abs_diff(4).max(j.abs_diff(4))
}

/// A ring of 36 × 36 × 20 mm with a ring-shaped chamber and one inlet.
const RING: Cubes = Cubes {
    count: [9, 9, 5],
    solid: |c| ring(c) > 1,
    chamber: |c| (ring(c) == 3 && c[2] == 2) || (c[0] == 7 && c[1] == 4 && c[2] < 2),
};

/// How bodies are moved: turned obliquely; in tests that take longer as they are, smaller,
/// larger and lying on their sides, too.
struct Cases {
    maps: Vec<Matrix3<f64>>,
    sizes: Vec<f64>,
}

impl Cases {
    fn few() -> Self {
        let axis = Unit::new_normalize(Vec3::new(1.0, 2.0, 3.0));
        let oblique = Rotation3::from_axis_angle(&axis, 0.7).into_inner();
        Self { maps: vec![oblique], sizes: vec![1.0] }
    }

    fn others() -> Self {
        let aside = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let sized = |size: f64| Matrix3::identity() * size;
        Self { maps: vec![sized(1.0), sized(0.75), sized(1.5), aside], sizes: vec![0.75, 1.5] }
    }

    /// The outcomes of a body; what is wrong is refused before anything is written.
    fn outcomes(&self, body: &Cubes, config: &str) -> Vec<Outcome> {
        let molded =
            |map: &Matrix3<f64>| outcome(&moved(Scene::planned(body, config), |p| *p = map * *p));
        let found: Vec<Outcome> = self.maps.iter().map(molded).collect();
        let rejected = |outcome: &&Outcome| matches!(outcome, Outcome::Rejected(_));
        assert_eq!(found.iter().find(rejected), None, "accepted by fab mold only");
        found
    }

    fn all_verified(&self, body: &Cubes, config: &str) {
        for (i, outcome) in self.outcomes(body, config).into_iter().enumerate() {
            assert_eq!(outcome, Outcome::Verified, "case {i}");
        }
    }

    fn all_refused(&self, body: &Cubes, config: &str, because: &str) {
        for (i, outcome) in self.outcomes(body, config).into_iter().enumerate() {
            match outcome {
                Outcome::Refused(said) => assert!(said.contains(because), "case {i}: {said}"),
                other => panic!("case {i}: {other:?}"),
            }
        }
    }

    fn a_ring(&self) {
        self.all_verified(&RING, "");
    }

    fn two_chambers_and_two_inlets(&self) {
        self.all_verified(&TWO_CHAMBERS, "");
        // No core can be held from below: halves, or a refusal that says so.
        self.all_refused(&OPPOSED, "method = \"soluble\"", "away from straight down");
        self.all_verified(&OPPOSED, "method = \"halves\"");
    }

    fn a_closed_chamber(&self) {
        self.all_verified(&CLOSED, "");
        self.all_verified(&CLOSED, "method = \"halves\"");
        self.all_refused(&CLOSED, "method = \"soluble\"", "is closed");
    }

    fn a_fin_too_thin_for_silicone(&self) {
        // The sheet is pressed to a tenth.
        let press = |p: &mut Vec3| {
            if p.x > 5.5 * CELL {
                p.y = 3.5 * CELL + 0.1 * (p.y - 3.5 * CELL);
            }
        };
        let plane = "[parting]\nkind = \"plane\"";
        for &size in &self.sizes {
            let thickness = format!("the silicone is {:.3} mm thick", 0.4 * size);
            let pressed = |config: &str| {
                moved(Scene::new(&FIN, config), |p| {
                    press(p);
                    *p *= size;
                })
            };
            match outcome(&pressed(plane)) {
                Outcome::Refused(said) => {
                    assert!(said.contains(&thickness), "{said}");
                }
                other => panic!("{size}: {other:?}"),
            }
            let thinner = format!("{plane}\n[casting]\nleast_wall = 2.9e-4");
            assert_eq!(outcome(&pressed(&thinner)), Outcome::Verified, "{size}");
        }
    }

    /// Shells that come off sideways meet no undercut.
    fn mushrooms_and_spools(&self) {
        self.all_verified(&MUSHROOM, "");
        self.all_verified(&SPOOL, "");
    }

    /// By 12 mm on both sides, the cap of 36 mm would have to give way: the shell above is split
    /// where that frees it. Above its foot the shell of the spool is split, but is caught on the
    /// foot.
    fn mushrooms_and_spools_pulled_along_their_stems(&self) {
        for &size in &self.sizes {
            let offset = 0.018 * size;
            let upward =
                format!("[parting]\nkind = \"plane\"\npull = [0, 0, 1]\noffset = {offset}");
            let of = |body| outcome(&moved(Scene::new(body, &upward), |p| *p *= size));
            assert_eq!(of(&MUSHROOM), Outcome::Verified, "{size}");
            match of(&SPOOL) {
                Outcome::Refused(said) => assert!(said.contains("cannot be peeled"), "{said}"),
                other => panic!("{size}: {other:?}"),
            }
        }
    }

    fn height_fields_along_the_stem_of_a_mushroom(&self) {
        for &(size, cell, expected) in HEIGHT_FIELDS.iter().filter(|f| self.sizes.contains(&f.0)) {
            let upward =
                format!("[parting]\nkind = \"height-field\"\npull = [0, 0, 1]\ncell = {cell}");
            let found = outcome(&moved(Scene::new(&MUSHROOM, &upward), |p| *p *= size));
            match expected {
                Field::Verified => assert_eq!(found, Outcome::Verified, "{size}, {cell}"),
                Field::SheetsTouch => match found {
                    Outcome::Refused(said) => {
                        assert!(said.contains("after rounding"), "{size}, {cell}: {said}");
                    }
                    other => panic!("{size}, {cell}: {other:?}"),
                },
            }
        }
    }
}

/// What becomes of a height field.
#[derive(Clone, Copy)]
enum Field {
    /// Parts, and every check holds.
    Verified,
    /// No parts: sheets of its steps touch after rounding.
    SheetsTouch,
}

/// Height fields along the stem of a mushroom: its size, the spacing of the columns [m], and what
/// becomes of them. What lies below the cap belongs to the lower shell, which leaves downward.
const HEIGHT_FIELDS: [(f64, f64, Field); 9] = [
    (0.75, 6e-4, Field::Verified),
    (0.75, 8e-4, Field::Verified),
    (0.75, 1.1e-3, Field::Verified),
    (1.0, 6e-4, Field::Verified),
    (1.0, 8e-4, Field::Verified),
    (1.0, 1.1e-3, Field::Verified),
    (1.5, 6e-4, Field::SheetsTouch),
    (1.5, 8e-4, Field::Verified),
    (1.5, 1.1e-3, Field::Verified),
];

#[test]
fn a_ring() {
    Cases::few().a_ring();
}

/// Two chambers, one with an inlet from below and one from above.
const OPPOSED: Cubes = Cubes {
    count: [9, 7, 6],
    solid: |_| true,
    chamber: |[i, j, k]| match i {
        0..4 => (CHAMBER.chamber)([i, j, k]),
        4 => false,
        _ => {
            let room = (5..8).contains(&i) && (2..5).contains(&j) && (1..4).contains(&k);
            room || (i == 6 && j == 3 && k > 3)
        }
    },
};

#[test]
#[ignore = "eight seconds: runs in make test-all; two chambers have cores in mold.rs"]
fn two_chambers_and_two_inlets() {
    Cases::few().two_chambers_and_two_inlets();
}

#[test]
#[ignore = "six seconds: runs in make test-all; plan.rs casts halves, also across an oblique plane"]
fn a_closed_chamber() {
    Cases::few().a_closed_chamber();
}

/// The chamber with a sheet of 4 mm at its side, 40 mm long.
const FIN: Cubes =
    Cubes { count: [15, 7, 6], solid: |[i, j, _]| i < 5 || j == 3, chamber: CHAMBER.chamber };

#[test]
#[ignore = "three seconds: runs in make test-all; damage.rs has a wall that is too thin"]
fn a_fin_too_thin_for_silicone() {
    Cases::few().a_fin_too_thin_for_silicone();
}

/// A stem of 12 mm under a cap of 36 mm, with a chamber in the stem.
const MUSHROOM: Cubes = Cubes {
    count: [9, 9, 9],
    solid: |[i, j, k]| k > 5 || ((3..6).contains(&i) && (3..6).contains(&j)),
    chamber: |[i, j, k]| i == 4 && j == 4 && k < 5,
};

/// Shells that part along the stem, half-way up it: the upper one is caught under the cap.
const STEM: &str = "[limits]\npeel = 0.2\n[parting]\nkind = \"plane\"\npull = [0, 0, 1]\n";

#[test]
fn a_mushroom_is_freed_by_splitting_its_upper_shell() {
    let scene = Scene::new(&MUSHROOM, &format!("{STEM}offset = 0.01"));
    assert_eq!(outcome(&scene), Outcome::Verified);
    let report = fab::files::report::MoldReport::read(&scene.path("mold")).unwrap();
    let parts: Vec<(&str, [f64; 3])> =
        report.parts.iter().map(|part| (part.name.as_str(), part.demolding)).collect();
    assert_eq!(parts[0], ("left", [0.0, 1.0, 0.0]));
    assert_eq!(parts[1], ("right", [0.0, -1.0, 0.0]));
    assert_eq!(parts[2], ("base", [0.0, 0.0, -1.0]));
    // A base on which the spool's cap stands would be caught on its foot.
    match outcome(&Scene::new(&SPOOL, &format!("{STEM}offset = 0.03"))) {
        Outcome::Refused(message) => assert!(message.contains("cannot be peeled"), "{message}"),
        other => panic!("{other:?}"),
    }
}

/// The mushroom on a foot as wide as its cap.
const SPOOL: Cubes = Cubes { solid: |c| c[2] < 3 || (MUSHROOM.solid)(c), ..MUSHROOM };

#[test]
#[ignore = "seven seconds: runs in make test-all"]
fn mushrooms_and_spools() {
    Cases::few().mushrooms_and_spools();
}

#[test]
#[ignore = "ten seconds: runs in make test-all"]
fn height_fields_along_the_stem_of_a_mushroom() {
    Cases::few().height_fields_along_the_stem_of_a_mushroom();
}

/// Numbers in [-1, 1) that look random, with a fixed seed (Knuth's linear congruence).
fn noise() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Noise of up to a part of a cell, everywhere.
fn shaken(part: f64, config: &str) -> Outcome {
    let mut random = noise();
    let shake = |p: &mut Vec3| *p += Vec3::new(random(), random(), random()) * part * CELL;
    outcome(&bent(&CHAMBER, config, shake))
}

/// Bumps of a scan are undercuts, but shallow ones.
const SOFT: &str = "[limits]\npeel = 5";

#[test]
#[ignore = "six seconds: runs in make test-all; a_scan_with_fine_noise_keeps_its_plan stays"]
fn a_scan_with_noise() {
    // Up to 0.4 mm, also where the inlet is.
    assert_eq!(shaken(0.1, SOFT), Outcome::Verified);
}

#[test]
fn a_scan_with_fine_noise_keeps_its_plan() {
    // Up to 0.2 mm everywhere, and no limit changed.
    assert_eq!(shaken(0.05, ""), Outcome::Verified);
}

#[test]
#[ignore = "takes tens of seconds: runs in make test-all"]
fn other_scans_with_noise() {
    let mut random = noise();
    // Up to 0.4 mm, but not where the body sits.
    let shake = |p: &mut Vec3| {
        if p.z > 1e-9 {
            *p += Vec3::new(random(), random(), random()) * 0.1 * CELL;
        }
    };
    assert_eq!(outcome(&bent(&CHAMBER, SOFT, shake)), Outcome::Verified);
    let sideways = "[parting]\nkind = \"plane\"\npull = [0, 1, 0]";
    assert_eq!(shaken(0.05, sideways), Outcome::Verified);
}

#[test]
#[ignore = "takes minutes: runs in make test-all"]
fn other_sizes_and_directions() {
    let others = Cases::others();
    others.a_ring();
    others.two_chambers_and_two_inlets();
    others.a_closed_chamber();
    others.a_fin_too_thin_for_silicone();
    others.mushrooms_and_spools();
    let all = Cases { sizes: vec![0.75, 1.0, 1.5], ..Cases::others() };
    all.mushrooms_and_spools_pulled_along_their_stems();
    others.height_fields_along_the_stem_of_a_mushroom();
}

/// A sheet of 288 × 288 × 3 cells with a flat chamber, whose boundary has 600 000 triangles.
const SHEET: Cubes = Cubes {
    count: [288, 288, 3],
    solid: |_| true,
    chamber: |[i, j, k]| {
        let inside = |low: usize| (low..288 - low).contains(&i) && (low..288 - low).contains(&j);
        (k == 1 && inside(14)) || (k == 0 && inside(140))
    },
};

#[test]
#[ignore = "takes minutes: runs in make test-all"]
fn half_a_million_triangles() {
    let shrink = |p: &mut Vec3| *p *= 0.1;
    let scene = bent(&SHEET, "[casting]\nleast_wall = 3e-4", shrink);
    let start = Instant::now();
    let outcome = outcome(&scene);
    eprintln!("made and verified in {:.1} s", start.elapsed().as_secs_f64());
    assert_eq!(outcome, Outcome::Verified);
}
