//! Numbers of cores and sockets, as dots that are sunk into a face.
//!
//! Dots are cones no steeper than a printer bridges, whatever the face: strokes of letters would
//! hang over, or be thinner than a nozzle, where stubs are a few millimetres wide.

use mesh::Vec3;
use mesh::solid::Solid;

use super::label::Face;

/// Digits of 3 × 5 dots, row by row from above.
const DIGITS: [[&str; 5]; 10] = [
    ["###", "# #", "# #", "# #", "###"],
    [" # ", "## ", " # ", " # ", "###"],
    ["###", "  #", "###", "#  ", "###"],
    ["###", "  #", "###", "  #", "###"],
    ["# #", "# #", "###", "  #", "  #"],
    ["###", "#  ", "###", "  #", "###"],
    ["###", "#  ", "###", "# #", "###"],
    ["###", "  #", "  #", " # ", " # "],
    ["###", "# #", "###", "# #", "###"],
    ["###", "# #", "###", "  #", "###"],
];

/// Least and largest distance of dots [m].
const PITCH: [f64; 2] = [6.5e-4, 1.1e-3];

/// Radius of a dot [pitch].
const DOT: f64 = 0.42;

/// Depth of a dot in a face that stands upright, and in one that lies on the printer's bed, over its radius:
/// its steepest overhang is 39° from the vertical.
const DEPTH: [f64; 2] = [0.8, 1.25];

/// Radius of a dot at its end, over that at the face.
const END: f64 = 0.1;

/// Sides of a dot.
const SIDES: usize = 12;

/// Extent of a number at a pitch of 1.
fn extent(number: usize) -> [f64; 2] {
    let columns = 4 * number.to_string().len() - 1;
    [columns as f64 - 1.0 + 2.0 * DOT, 4.0 + 2.0 * DOT]
}

/// The largest extent of a number [m].
pub fn largest(number: usize) -> [f64; 2] {
    extent(number).map(|size| size * PITCH[1])
}

/// The dots of a number in the middle of a face, as large as it fits; none if it would be too small to be
/// printed.
pub fn dots(number: usize, face: &Face) -> Option<Solid> {
    let [width, height] = extent(number);
    let pitch = (face.size[0] / width).min(face.size[1] / height).min(PITCH[1]);
    if pitch < PITCH[0] {
        return None;
    }
    let out = face.along.cross(&face.up);
    let radius = DOT * pitch;
    let depth = radius * if out.dot(&face.down) > 0.5 { DEPTH[1] } else { DEPTH[0] };
    // From as far outside as it is deep.
    let dot = |middle: Vec3| {
        let wide = radius * (2.0 - END);
        Solid::cylinder(&(middle + out * depth), &(out * (-2.0 * depth)), wide, END * radius, SIDES)
    };
    let digits = number.to_string();
    let columns = (4 * digits.len() - 1) as f64;
    let mut all: Option<Solid> = None;
    for (n, digit) in digits.bytes().enumerate() {
        for (row, line) in DIGITS[usize::from(digit - b'0')].iter().enumerate() {
            for column in line.bytes().enumerate().filter(|(_, c)| *c == b'#').map(|(i, _)| i) {
                let x = (4 * n + column) as f64 - (columns - 1.0) / 2.0;
                let at = face.middle + (face.along * x + face.up * (2.0 - row as f64)) * pitch;
                let dot = dot(at);
                all = Some(all.map_or_else(|| dot.clone(), |all| all.union(&dot)));
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geometry::overhang::{CUSTOMARY, Overhangs, needs_supports};

    #[test]
    fn dots_of_any_number_are_printed_without_supports() {
        for (along, up) in [(Vec3::y(), Vec3::z()), (Vec3::x(), -Vec3::y())] {
            for number in [8, 18] {
                let out = along.cross(&up);
                let face =
                    Face { middle: out * 10.0, along, up, size: [9.0, 9.0], down: -Vec3::z() };
                // In millimetres, as it is printed, with dots as large as metres allow.
                let face = Face { middle: face.middle * 1e-3, size: [9e-3, 9e-3], ..face };
                let block = Solid::cube(&Vec3::repeat(-10e-3), &Vec3::repeat(10e-3));
                let dotted = block.difference(&dots(number, &face).unwrap());
                let mut printed = dotted.to_surface();
                printed.vertices.iter_mut().for_each(|p| *p *= 1e3);
                let below = Overhangs::new(&printed, CUSTOMARY, |_| true);
                assert!(dotted.volume() < block.volume());
                assert!(!needs_supports(below.hanging), "{number}: {below:?}");
            }
        }
    }

    #[test]
    fn numbers_differ_and_fit_their_face() {
        let face = |size| Face {
            middle: Vec3::zeros(),
            along: Vec3::y(),
            up: Vec3::z(),
            size: [size, size],
            down: -Vec3::z(),
        };
        // 2 and 3 have as many dots, at other places
        let numbers = [1, 2, 3, 7, 8].map(|n| dots(n, &face(5e-3)).unwrap());
        for pair in numbers.windows(2) {
            let apart =
                pair[0].difference(&pair[1]).volume() + pair[1].difference(&pair[0]).volume();
            assert!(apart > 0.1 * pair[0].volume(), "{apart}");
        }
        let (low, high) = dots(3, &face(4e-3)).unwrap().trim_by_plane(&-Vec3::x(), 0.0).bounds();
        assert!(high.z - low.z < 4e-3 + 1e-9 && high.y - low.y < 4e-3, "{low} {high}");
        assert!(dots(3, &face(3e-3)).is_none());
    }
}
