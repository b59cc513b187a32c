//! How small a damage to the space between the parts `fab verify` finds.
//!
//! `surface` compares distances with 5 µm and ignores films thinner than that; volumes are
//! compared with what rounding the files can change, δ·A, about 0.01 mm³ here. What is thinner
//! than 5 µm is therefore found only if its volume exceeds that.

#![allow(clippy::unwrap_used)]

use crate::fixture::damaged::{after, change_solid, cube};
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

/// A box over a place on the inside of the lower shell beside the body, at y = −14 mm, from `y0` to `y1`.
fn at_wall([low, high]: [[f64; 2]; 2], y0: f64, y1: f64) -> Solid {
    cube([low[0], y0, low[1]], [high[0], y1, high[1]])
}

/// A small and a large place of it.
const SMALL: [[f64; 2]; 2] = [[-1.0, 2.0], [1.0, 4.0]];
const LARGE: [[f64; 2]; 2] = [[-6.0, 2.0], [6.0, 10.0]];

/// Sizes at which each damage is found.
#[test]
#[ignore = "a minute: runs in make test-all; damage.rs has one size of each"]
fn damages_are_found_down_to_their_sizes() {
    let pit = |lower: Solid, place, d: f64| lower.difference(&at_wall(place, -14.0 - d, -13.0));
    let film = |lower: Solid, place, d: f64| lower.union(&at_wall(place, -14.5, -14.0 + d));
    // 2 mm deep into the wall
    let slot = |lower: Solid, high: f64, d: f64| {
        lower.difference(&cube([-d / 2.0, -16.0, 2.0], [d / 2.0, -13.0, 2.0 + high]))
    };
    type Damage<'a> = &'a dyn Fn(Solid, f64) -> Solid;
    let damages: [(&str, &str, Damage, &[f64]); 7] = [
        ("core", "shift", &|core, d| core.translate(&Vec3::new(d, 0.0, 0.0)), &SIZES),
        ("lower", "pit of 2 x 2 mm", &|lower, d| pit(lower, SMALL, d), &SIZES[2..]),
        ("lower", "pit of 12 x 8 mm", &|lower, d| pit(lower, LARGE, d), &SIZES),
        ("lower", "film of 2 x 2 mm", &|lower, d| film(lower, SMALL, d), &SIZES[3..]),
        ("lower", "film of 12 x 8 mm", &|lower, d| film(lower, LARGE, d), &SIZES),
        ("lower", "slot 2 mm high", &|lower, d| slot(lower, 2.0, d), &SIZES[2..]),
        ("lower", "slot 8 mm high", &|lower, d| slot(lower, 8.0, d), &SIZES[1..]),
    ];
    for (part, what, damage, expected) in damages {
        let found = |size: &f64| {
            let lines = after(|mold| change_solid(mold, part, |solid| damage(solid, size * 1e-3)));
            !failed(&lines).is_empty()
        };
        let sizes: Vec<f64> = SIZES.into_iter().filter(found).collect();
        assert_eq!(sizes, expected, "{what}");
    }
}
