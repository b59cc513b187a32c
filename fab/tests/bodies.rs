//! What becomes of bodies: parts for which every check holds, or a clear refusal.

#![allow(clippy::unwrap_used)]

use crate::fixture::{CELL, CHAMBER, CLOSED, Cubes, Scene, TWO_CHAMBERS, TWO_TOPS};
use mesh::Vec3;
use nalgebra::{Matrix3, Rotation3, Unit};

/// Where a point of a body goes.
type Place = fn(&mut Vec3);

/// A turn about an oblique axis.
fn turn(angle: f64) -> Matrix3<f64> {
    let axis = Unit::new_normalize(Vec3::new(1.0, 2.0, 3.0));
    Rotation3::from_axis_angle(&axis, angle).into_inner()
}

fn oblique(p: &mut Vec3) {
    *p = turn(0.7) * *p;
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

/// The chamber with a sheet of 4 mm at its side, 40 mm long.
const FIN: Cubes =
    Cubes { count: [15, 7, 6], solid: |[i, j, _]| i < 5 || j == 3, chamber: CHAMBER.chamber };

/// Presses the sheet to a tenth.
fn pressed_fin(p: &mut Vec3) {
    if p.x > 5.5 * CELL {
        p.y = 3.5 * CELL + 0.1 * (p.y - 3.5 * CELL);
    }
}

/// Presses one side of the chamber from 8 mm to 0.8 mm.
fn pressed_side(p: &mut Vec3) {
    if p.y < 2.0 * CELL {
        p.y = 2.0 * CELL - 0.1 * (2.0 * CELL - p.y);
    }
}

/// A stem of 12 mm under a cap of 36 mm, with a chamber in the stem.
const MUSHROOM: Cubes = Cubes {
    count: [9, 9, 9],
    solid: |[i, j, k]| k > 5 || ((3..6).contains(&i) && (3..6).contains(&j)),
    chamber: |[i, j, k]| i == 4 && j == 4 && k < 5,
};

/// The mushroom on a foot as wide as its cap.
const SPOOL: Cubes = Cubes { solid: |c| c[2] < 3 || (MUSHROOM.solid)(c), ..MUSHROOM };

/// A box of 44 × 44 × 16 mm, cast face down with its chamber open, and a tooth of 4 mm above the lid: too small to count
/// against the plane of the lid, but it must give way by its width.
const TOOTH: Cubes = Cubes {
    count: [12, 11, 4],
    solid: |[i, j, k]| i < 11 || (j == 5 && k == 2),
    chamber: |[i, j, k]| {
        let within = |low: usize| (low..11 - low).contains(&i) && (low..11 - low).contains(&j);
        (k == 1 && within(2)) || (k == 2 && within(4))
    },
};

/// A closed chamber of 8 mm in a box of 24 mm, with vertices half-way through both.
const HALVED: Cubes =
    Cubes { count: [6, 6, 6], solid: |_| true, chamber: |c| c.iter().all(|k| (2..4).contains(k)) };

#[test]
fn sound_bodies_are_verified() {
    let across = "parting = { kind = \"height-field\", pull = [0, 1, 0] }\nmethod = \"soluble\"";
    let oblique_pull =
        "up = [0, 0, 1]\nparting = { kind = \"plane\", pull = [-1, 1, 0] }\nmethod = \"soluble\"";
    for (body, config) in [
        (&TOOTH, ""),
        (&CHAMBER, across),
        (&CHAMBER, oblique_pull),
        // The inlet leaves the body across the plane, not at a slant on which the lid would lock.
        (&CHAMBER, "method = \"halves\""),
    ] {
        Scene::planned(body, config).verified();
    }
    Scene::planned(&RING, "").moved(oblique).verified();
    // A scan with noise of up to 0.2 mm everywhere: numbers that look random (Knuth's linear congruence).
    let mut state = 1_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let shake = |p: &mut Vec3| *p += Vec3::new(random(), random(), random()) * (0.05 * CELL);
    Scene::new(&CHAMBER, "").moved(shake).verified();
}

/// A plane across which halves are glued.
fn glued(normal: &str) -> String {
    format!("method = \"halves\"\n[limits]\npeel = 5\n[gluing]\nnormal = {normal}")
}

#[test]
#[ignore = "a minute: runs in make test-all"]
fn more_sound_bodies_are_verified() {
    let fin = "method = \"soluble\"\ncasting.least_wall = 2.9e-4\nparting.kind = \"plane\"";
    let cases: [(&Cubes, Place, &str); 8] = [
        (&TWO_CHAMBERS, oblique, ""),
        (&OPPOSED, oblique, "method = \"halves\""),
        (&CLOSED, oblique, ""),
        (&CLOSED, oblique, "method = \"halves\""),
        // Shells that come off sideways meet no undercut.
        (&MUSHROOM, oblique, ""),
        (&SPOOL, oblique, ""),
        (&FIN, pressed_fin, fin),
        // 216 mm long: rounding of the whole body exceeds what the mouth of a vent holds.
        (&TWO_TOPS, |p| *p *= 6.0, "method = \"soluble\""),
    ];
    for (body, place, config) in cases {
        Scene::planned(body, config).moved(place).verified();
    }
    // What lies below the cap belongs to the lower shell, which leaves downward.
    for cell in [6e-4, 8e-4, 1.1e-3] {
        let field = format!("[parting]\nkind = \"height-field\"\npull = [0, 0, 1]\ncell = {cell}");
        Scene::new(&MUSHROOM, &field).verified();
    }
    // The hull of a box that stands on edge has but a narrow face in front, on which its name stands.
    for angle in [0.3, 0.6, 0.9, 1.2] {
        let scene = Scene::planned(&CLOSED, "method = \"open-top\"");
        assert_eq!(scene.moved(|p| *p = turn(angle) * *p * 0.5).made().molds.len(), 2);
    }
    // Turned, vertices half-way are off the plane of the halves by the rounding of a float.
    for angle in [0.0, 0.3, 0.7] {
        let [x, y, z]: [f64; 3] = turn(angle).column(0).into_owned().into();
        let config = format!("method = \"halves\"\n[gluing]\nnormal = [{x}, {y}, {z}]");
        Scene::planned(&HALVED, &config).moved(|p| *p = turn(angle) * *p).verified();
    }
    for normal in ["[0, 1, 2]", "[0.1, -1, 0.2]", "[1, 2, 3]"] {
        Scene::planned(&CLOSED, &glued(normal)).verified();
    }
}

/// Cut surfaces that are not along coordinate planes differ in the last bits between body, filled body and core.
#[test]
fn halves_are_glued_across_an_oblique_plane() {
    assert_eq!(Scene::planned(&CLOSED, &glued("[-2, 1, 0.3]")).made().molds.len(), 2);
}

/// Shells that part along the stem, half-way up it: the upper one is caught under the cap.
const STEM: &str = "[limits]\npeel = 0.2\n[parting]\nkind = \"plane\"\npull = [0, 0, 1]\n";

#[test]
fn a_mushroom_is_freed_by_splitting_its_upper_shell() {
    let scene = Scene::new(&MUSHROOM, &format!("{STEM}offset = 0.01"));
    scene.verified();
    let parts = scene.report(".").parts;
    let parts = parts.iter().map(|part| (part.name.as_str(), part.demolding)).take(3);
    let expected =
        [("left", [0.0, 1.0, 0.0]), ("right", [0.0, -1.0, 0.0]), ("base", [0.0, 0.0, -1.0])];
    assert_eq!(parts.collect::<Vec<_>>(), expected);
}

/// Moves a vertex by millimetres.
fn spoil(p: &mut Vec3, place: [f64; 3], by: Vec3) {
    if (*p - Vec3::from(place) * 1e-3).norm() < 1e-9 {
        *p += by * 1e-3;
    }
}

#[test]
fn what_cannot_be_made_is_refused_with_the_reason() {
    let spool = format!("{STEM}offset = 0.03");
    let plane = "[parting]\nkind = \"plane\"\n";
    let tilted = format!("{plane}pull = [0, 1, 1]");
    let columns = "[parting]\nkind = \"height-field\"\ncell = 2e-5\nsmoothing = 1e-4";
    let tube = "[fitting]\nname = \"tube-4x2.5\"\n";
    let thick = format!("{tube}wall = 0.03\n");
    let pin = "[core]\npins = [[0.007, 0.017, 0.024]]\npin = 5.5e-3\n";
    let no_pin = ["no pin of 5.50 mm radius", "within 22.0 mm of (0.007, 0.017", "near to sprue"];
    let stretch =
        ["core is 48.0 mm around, its inlet 16.0 mm", "to 3.00 times its", "possible are"];
    let unknown = "mold.toml:2:1: unknown field `wal`; did you mean `wall`? expected one of `chamber`, `method`, `layers`, `wound`";
    let cases: &[(&Cubes, &str, &[&str])] = &[
        // A base on which the spool's cap stands would be caught on its foot.
        (&SPOOL, &spool, &["cannot be peeled"]),
        (&CHAMBER, pin, &no_pin),
        (&CHAMBER, "[core]\nsupport = \"pin\"\npin = 5.5e-3", &["finds room at the core"]),
        // A wrong choice, with what was measured, and what is possible.
        (&CHAMBER, "method = \"pull-out\"", &stretch),
        (&CLOSED, "", &["a chamber of 1728.0 mm³ is closed", "\"halves\""]),
        (&CHAMBER, "method = \"glue\"", &["unknown variant `glue`", "`pull-out`"]),
        (&CHAMBER, "wal = 1", &[unknown, "`around`, `surface`"]),
        (&CHAMBER, "chamber = \"hole\"", &["seat (68 facets), cavity (122 facets), skin (358"]),
        (&CLOSED, "chamber = \"skin\"", &["separate pieces"]),
        (&CHAMBER, "up = [1, 0, 0]", &["faces 90.0° away from straight down"]),
        (&CHAMBER, &tilted, &["makes an angle of 45.00° with up"]),
        (&CHAMBER, "[sprue]\nat = [1, 0, 0]", &["does not meet the part"]),
        (&CHAMBER, "core.shoulder = 1.6e-3", &["an inscribed radius of 2.000 mm, at least 2.4"]),
        (&CHAMBER, columns, &["columns"]),
        (&CHAMBER, "layers = [\"card\"]", &["the tag \"card\"; the mesh has: seat"]),
        (&CLOSED, tube, &["a chamber is closed"]),
        (&CHAMBER, &thick, &["lies on the body with"]),
    ];
    for (body, config, words) in cases {
        Scene::new(body, config).refused(2, words);
    }
    let thin = "the silicone is 0.800 mm thick at (";
    let moved: &[(&Cubes, Place, &str, &str)] = &[
        // No core can be held from below.
        (&OPPOSED, oblique, "", "away from straight down"),
        (&FIN, pressed_fin, plane, "the silicone is 0.400 mm thick"),
        (&CHAMBER, pressed_side, "", thin),
        (&CHAMBER, pressed_side, "method = \"halves\"", thin),
        (&CHAMBER, pressed_side, "method = \"open-top\"", thin),
        // A corner of the inlet is lifted; an inner vertex goes through the opposite faces of its tetrahedra.
        (&CHAMBER, |p| spoil(p, [8.0, 12.0, 0.0], Vec3::z()), "", "leaves its plane by"),
        (&CHAMBER, |p| spoil(p, [4.0, 8.0, 4.0], Vec3::x() * 5.0), "", "some are inverted or over"),
    ];
    for (body, place, config, word) in moved {
        Scene::new(body, config).moved(place).refused(2, &[*word]);
    }
}
