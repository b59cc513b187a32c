//! How small a damage to the space between the parts `fab verify` finds.
//!
//! `surface` compares distances with 5 µm and ignores films thinner than that; volumes are
//! compared with what rounding the files can change, δ·A, about 0.01 mm³ here. What is thinner
//! than 5 µm is therefore found only if its volume exceeds that.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::fixture::damaged::{after, change, change_solid, cube, moved};
use fab::verify::{Line, Status};
use mesh::Vec3;
use mesh::solid::Solid;

/// Sizes of damages [µm].
const SIZES: [f64; 5] = [1.0, 3.0, 5.0, 10.0, 50.0];

/// The checks that failed, but for overhangs, which a mold made so would report as they are.
fn failed(lines: &[Line]) -> Vec<&str> {
    let failed = lines.iter().filter(|line| line.status == Status::Fail);
    failed.map(|line| line.name.as_str()).filter(|name| !name.ends_with(": overhang")).collect()
}

/// The sizes at which a damage is found, and by which checks.
fn assert_found(what: &str, damage: impl Fn(&Path, f64), expected: &[f64]) {
    let mut sizes = Vec::new();
    let mut checks = Vec::new();
    for size in SIZES {
        let lines = after(|mold| damage(mold, size * 1e-3));
        let failed = failed(&lines);
        sizes.extend((!failed.is_empty()).then_some(size));
        checks.push(format!("{size} µm: {failed:?}"));
    }
    assert_eq!(sizes, expected, "{what}: {checks:#?}");
}

/// The inside of the lower shell beside the body, at y = −14 mm; a small and a large place of it.
const SMALL: [[f64; 2]; 2] = [[-1.0, 2.0], [1.0, 4.0]];
const LARGE: [[f64; 2]; 2] = [[-6.0, 2.0], [6.0, 10.0]];

/// A box over a place on the wall, from `y0` to `y1`.
fn at_wall([low, high]: [[f64; 2]; 2], y0: f64, y1: f64) -> Solid {
    cube([low[0], y0, low[1]], [high[0], y1, high[1]])
}

#[test]
#[ignore = "four seconds: runs in make test-all; damage.rs shifts the core by 100 µm"]
fn a_core_that_is_shifted() {
    let shift = |mold: &Path, d: f64| {
        change(mold, "core", |s| moved(s, Vec3::new(d, 0.0, 0.0)));
    };
    assert_found("shift of the core", shift, &SIZES);
}

#[test]
#[ignore = "seven seconds: runs in make test-all, with films and slots"]
fn a_pit_in_the_wall() {
    let pit = |place| {
        move |mold: &Path, d: f64| {
            change_solid(mold, "lower", |lower| {
                lower.difference(&at_wall(place, -14.0 - d, -13.0))
            });
        }
    };
    assert_found("pit of 2 x 2 mm", pit(SMALL), &SIZES[2..]);
    assert_found("pit of 12 x 8 mm", pit(LARGE), &SIZES);
}

#[test]
#[ignore = "takes tens of seconds, and a pit is found alike: runs in make test-all"]
fn a_film_on_the_wall() {
    let film = |place| {
        move |mold: &Path, d: f64| {
            change_solid(mold, "lower", |lower| lower.union(&at_wall(place, -14.5, -14.0 + d)));
        }
    };
    assert_found("film of 2 x 2 mm", film(SMALL), &SIZES[3..]);
    assert_found("film of 12 x 8 mm", film(LARGE), &SIZES);
}

/// A slot of the given width, 2 mm deep into the wall.
#[test]
#[ignore = "takes tens of seconds: runs in make test-all"]
fn a_slot_in_the_wall() {
    let slot = |height: f64| {
        move |mold: &Path, d: f64| {
            let slot = cube([-d / 2.0, -16.0, 2.0], [d / 2.0, -13.0, 2.0 + height]);
            change_solid(mold, "lower", |lower| lower.difference(&slot));
        }
    };
    assert_found("slot 2 mm high", slot(2.0), &SIZES[2..]);
    assert_found("slot 8 mm high", slot(8.0), &SIZES[1..]);
}
