//! Raised letters.
//!
//! A glyph is five rows of three squares; squares reach a little over each other, so
//! that those that touch at a corner are one body.

use mesh::Vec3;
use mesh::solid::Solid;

/// Rows of a glyph, and columns with the gap to the next.
const ROWS: usize = 5;
const PITCH: usize = 4;

/// How far a square reaches over the next, in squares.
const OVER: f64 = 0.05;

/// How far letters stand out at most, and how deep they are rooted [m].
const RAISED: f64 = 5e-4;

/// The undersides of letters recede by this for each unit that they stand out: 39° from the
/// vertical, so that they are printed without support.
const RECEDES: f64 = 1.25;

/// Rows from the top, three bits each; 0 for what has no glyph.
fn glyph(c: char) -> [u8; ROWS] {
    match c {
        'A' => [0b010, 0b101, 0b111, 0b101, 0b101],
        'B' => [0b110, 0b101, 0b110, 0b101, 0b110],
        'C' => [0b011, 0b100, 0b100, 0b100, 0b011],
        'D' => [0b110, 0b101, 0b101, 0b101, 0b110],
        'E' => [0b111, 0b100, 0b110, 0b100, 0b111],
        'F' => [0b111, 0b100, 0b110, 0b100, 0b100],
        'G' => [0b011, 0b100, 0b101, 0b101, 0b011],
        'H' => [0b101, 0b101, 0b111, 0b101, 0b101],
        'I' => [0b111, 0b010, 0b010, 0b010, 0b111],
        'L' => [0b100, 0b100, 0b100, 0b100, 0b111],
        'O' => [0b010, 0b101, 0b101, 0b101, 0b010],
        'P' => [0b110, 0b101, 0b110, 0b100, 0b100],
        'R' => [0b110, 0b101, 0b110, 0b101, 0b101],
        'S' => [0b011, 0b100, 0b010, 0b001, 0b110],
        'T' => [0b111, 0b010, 0b010, 0b010, 0b010],
        'U' => [0b101, 0b101, 0b101, 0b101, 0b111],
        'W' => [0b101, 0b101, 0b111, 0b111, 0b101],
        'Y' => [0b101, 0b101, 0b010, 0b010, 0b010],
        '1' => [0b010, 0b110, 0b010, 0b010, 0b111],
        '2' => [0b110, 0b001, 0b010, 0b100, 0b111],
        _ => [0; ROWS],
    }
}

/// A face across an axis that looks along `along` × `up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Middle of the face [m].
    pub middle: Vec3,
    /// Axis along which one reads [1].
    pub along: Vec3,
    /// Axis along which letters stand [1].
    pub up: Vec3,
    /// Its extent along both [m].
    pub size: [f64; 2],
    /// Axis along or against one of them that points down on the printer [1].
    pub down: Vec3,
}

/// The word in capitals, raised on the face as large as it fits; empty if it would be
/// lower than 2 mm.
#[must_use]
pub fn word(word: &str, face: &Face) -> Solid {
    let letters: Vec<char> = word.to_uppercase().chars().collect();
    let columns = (letters.len() * PITCH - 1) as f64;
    // One square free all around, and not more than 1 mm per square.
    let side = (face.size[1] / (ROWS + 2) as f64).min(face.size[0] / (columns + 2.0)).min(1e-3);
    let empty = Solid::cube(&Vec3::zeros(), &Vec3::zeros());
    if side * (ROWS as f64) < 2e-3 {
        return empty;
    }
    let raised = RAISED.min(side / 2.0);
    let squares = letters.iter().enumerate().flat_map(|(k, &c)| {
        let rows = glyph(c);
        (0..ROWS).flat_map(move |row| {
            let bits = (0..3).filter(move |column| rows[row] >> (2 - column) & 1 == 1);
            bits.map(move |column| [k * PITCH + column, row])
        })
    });
    let squares: Vec<[usize; 2]> = squares.collect();
    let out = face.along.cross(&face.up);
    let [right, rise] = [&face.along, &face.up].map(|axis| face.down.dot(axis).round() as isize);
    let stands_on_one = |[column, row]: [usize; 2]| {
        let below = column.checked_add_signed(right).zip(row.checked_add_signed(-rise));
        below.is_some_and(|(column, row)| squares.contains(&[column, row]))
    };
    squares.iter().fold(empty, |all, &[column, row]| {
        let left = column as f64 - columns / 2.0;
        let low = ROWS as f64 / 2.0 - 1.0 - row as f64;
        let corner = |u: f64, w: f64, y: f64| {
            face.middle + face.along * (u * side) + face.up * (w * side) + out * y
        };
        let a = corner(left - OVER, low - OVER, -RAISED);
        let b = corner(left + 1.0 + OVER, low + 1.0 + OVER, raised);
        let square = Solid::cube(&a.inf(&b), &a.sup(&b));
        if stands_on_one([column, row]) {
            return all.union(&square);
        }
        let slope = face.down + out * RECEDES;
        let lowest = a.dot(&face.down).max(b.dot(&face.down));
        let offset = (lowest + face.middle.dot(&out) * RECEDES) / slope.norm();
        all.union(&square.trim_by_plane(&-slope, -offset))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::overhang::{CUSTOMARY, Overhangs, needs_supports};
    use mesh::SurfaceMesh;

    #[test]
    fn every_name_of_a_piece_has_its_letters() {
        for word in ["upper", "lower", "left", "right", "base", "cup", "lid", "tray"] {
            for c in word.to_uppercase().chars() {
                assert_ne!(glyph(c), [0; ROWS], "{c} of {word}");
            }
        }
    }

    #[test]
    fn letters_fit_the_face_and_each_is_one_body() {
        let middle = Vec3::new(1.0, 2.0, 3.0);
        let (along, up) = (Vec3::x(), Vec3::z());
        let face = Face { middle, along, up, size: [40e-3, 7e-3], down: -up };
        let solid = word("cup", &face);
        assert_eq!(solid.decompose().len(), 3);
        let (low, high) = solid.bounds();
        let half = [(high.x - low.x) / 2.0, (high.z - low.z) / 2.0];
        assert!(half[0] < 20e-3 && half[1] < 3.5e-3, "{half:?}");
        assert!((high.y - low.y - 2.0 * RAISED).abs() < 1e-12);
        // U has more of its squares low.
        let u = word("u", &face);
        let half = u.trim_by_plane(&Vec3::z(), face.middle.z).volume();
        assert!(half < 0.5 * u.volume());
        let thin = Face { size: [40e-3, 2e-3], ..face };
        assert!(word("cup", &thin).is_empty());
    }

    #[test]
    fn no_letter_hangs_over_however_the_face_is_printed() {
        let (along, up) = (Vec3::x(), Vec3::z());
        for down in [-up, up, along, -along] {
            let middle = Vec3::zeros();
            let face = Face { middle, along, up, size: [40e-3, 7e-3], down };
            let wall = Solid::cube(&Vec3::new(-0.02, 0.0, -4e-3), &Vec3::new(0.02, 5e-3, 4e-3));
            let solid = wall.union(&word("upper", &face)).to_surface();
            // Printed with `down` against z.
            let side = down.cross(&Vec3::y());
            let turned = |p: &Vec3| Vec3::new(p.dot(&side), p.y, -p.dot(&down)) * 1e3;
            let vertices = solid.vertices.iter().map(turned).collect();
            let printed = SurfaceMesh { vertices, triangles: solid.triangles };
            let below = Overhangs::new(&printed, CUSTOMARY, |_| true);
            assert!(below.bed > 35.0 && !needs_supports(below.hanging), "{down} {below:?}");
        }
    }
}
