//! Bodies that are hard to mold: each ends in verified parts or in a clear refusal.

#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod fixture;

use std::time::Instant;

use fixture::{CELL, CHAMBER, Cubes, Scene, stderr, stdout};
use mesh::Vec3;
use mesh::io::{read_tets, write_tets};

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
    let scene = Scene::new(body, config);
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

/// A ring of 36 × 36 × 20 mm with a ring-shaped cavity and one inlet.
const RING: Cubes = Cubes {
    count: [9, 9, 5],
    solid: |c| ring(c) > 1,
    cavity: |c| (ring(c) == 3 && c[2] == 2) || (c[0] == 7 && c[1] == 4 && c[2] < 2),
};

#[test]
fn a_ring() {
    assert_eq!(outcome(&Scene::new(&RING, "")), Outcome::Verified);
}

/// The chamber with a sheet of 4 mm at its side, 40 mm long.
const FIN: Cubes =
    Cubes { count: [15, 7, 6], solid: |[i, j, _]| i < 5 || j == 3, cavity: CHAMBER.cavity };

#[test]
fn a_fin_too_thin_for_silicone() {
    // The sheet is pressed to 0.4 mm.
    let press = |p: &mut Vec3| {
        if p.x > 5.5 * CELL {
            p.y = 3.5 * CELL + 0.1 * (p.y - 3.5 * CELL);
        }
    };
    match outcome(&bent(&FIN, "[parting]\nkind = \"plane\"", press)) {
        Outcome::Rejected(lines) => {
            assert_eq!(lines.len(), 1, "{lines:#?}");
            assert!(lines[0].contains("silicone: thinnest wall"), "{lines:#?}");
            assert!(lines[0].contains("0.4000 mm"), "{lines:#?}");
        }
        other => panic!("{other:?}"),
    }
    let config = "[parting]\nkind = \"plane\"\n[casting]\nleast_wall = 3e-4";
    assert_eq!(outcome(&bent(&FIN, config, press)), Outcome::Verified);
}

/// A stem of 12 mm under a cap of 36 mm, with a chamber in the stem.
const MUSHROOM: Cubes = Cubes {
    count: [9, 9, 9],
    solid: |[i, j, k]| k > 5 || ((3..6).contains(&i) && (3..6).contains(&j)),
    cavity: |[i, j, k]| i == 4 && j == 4 && k < 5,
};

#[test]
fn a_mushroom() {
    // Shells that come off sideways meet no undercut.
    let sideways = "[parting]\nkind = \"plane\"\npull = [1, 0, 0]";
    assert_eq!(outcome(&Scene::new(&MUSHROOM, sideways)), Outcome::Verified);
}

/// Shells that part along the stem, half-way up it: the upper one is caught under the cap.
const STEM: &str = "[limits]\npeel = 0.2\n[parting]\nkind = \"plane\"\npull = [0, 0, 1]\n";

#[test]
fn a_mushroom_is_freed_by_splitting_its_upper_shell() {
    let scene = Scene::new(&MUSHROOM, &format!("{STEM}offset = 0.01"));
    assert_eq!(outcome(&scene), Outcome::Verified);
    let report = fab::report::Report::read(&scene.path("mold")).unwrap();
    let parts: Vec<(&str, [f64; 3])> =
        report.parts.iter().map(|part| (part.name.as_str(), part.leaves)).collect();
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
fn a_spool() {
    let sideways = "[parting]\nkind = \"plane\"\npull = [1, 0, 0]";
    assert_eq!(outcome(&Scene::new(&SPOOL, sideways)), Outcome::Verified);
    // The cap of 36 mm would have to give way by 12 mm.
    let upward = "[limits]\npeel = 0.3\n[parting]\nkind = \"height-field\"\npull = [0, 0, 1]";
    match outcome(&Scene::new(&SPOOL, upward)) {
        Outcome::Refused(message) => assert!(message.contains("cannot be peeled"), "{message}"),
        other => panic!("{other:?}"),
    }
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

#[test]
fn a_scan_with_noise() {
    let mut random = noise();
    // Up to 0.4 mm, but not where the body sits.
    let shake = |p: &mut Vec3| {
        if p.z > 1e-9 {
            *p += Vec3::new(random(), random(), random()) * 0.1 * CELL;
        }
    };
    // Bumps are undercuts, but shallow ones.
    let soft = "[limits]\npeel = 5";
    assert_eq!(outcome(&bent(&CHAMBER, soft, shake)), Outcome::Verified);
    let mut random = noise();
    let shake = |p: &mut Vec3| *p += Vec3::new(random(), random(), random()) * 0.1 * CELL;
    // The same where the inlet is uneven, too.
    assert_eq!(outcome(&bent(&CHAMBER, soft, shake)), Outcome::Verified);
}

#[test]
fn a_scan_with_fine_noise_keeps_its_plan() {
    let mut random = noise();
    // Up to 0.2 mm everywhere, and no limit changed.
    let shake = |p: &mut Vec3| *p += Vec3::new(random(), random(), random()) * 0.05 * CELL;
    assert_eq!(outcome(&bent(&CHAMBER, "", shake)), Outcome::Verified);
    let mut random = noise();
    let shake = |p: &mut Vec3| *p += Vec3::new(random(), random(), random()) * 0.05 * CELL;
    let sideways = "[parting]\nkind = \"plane\"\npull = [0, 1, 0]";
    assert_eq!(outcome(&bent(&CHAMBER, sideways, shake)), Outcome::Verified);
}

/// A sheet of 288 × 288 × 3 cells with a flat chamber, whose boundary has 600 000 triangles.
const SHEET: Cubes = Cubes {
    count: [288, 288, 3],
    solid: |_| true,
    cavity: |[i, j, k]| {
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
