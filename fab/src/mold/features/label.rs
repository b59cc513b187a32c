//! Raised letters.
//!
//! The letters of [`render::font`] in bold are extruded. On the way out they are slanted
//! upwards on the printer, so that no underside of a stroke needs support.

use mesh::Vec3;
use mesh::solid::Solid;
use nalgebra::Matrix3x4;
use render::font::{Weight, outlines};

/// Lowest and highest capitals [m]. The thinnest strokes are a sixth of the height: lower
/// letters have strokes below 0.4 mm, the width of a printed line.
pub const LOWEST: f64 = 2.5e-3;
const HIGHEST: f64 = 5e-3;

/// Least free space around the word [height of a capital].
const MARGIN: f64 = 0.2;

/// How far letters stand out at most, and how deep they are rooted [m]; of low letters a
/// tenth of their height.
const RAISED: f64 = 5e-4;

/// Letters rise by this on the printer for each unit that they stand out: their undersides
/// are 39° from the vertical and are printed without support.
const SLANT: f64 = 1.25;

/// A face across an axis that looks along `along` × `up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Middle of the face [m].
    pub middle: Vec3,
    /// Axis along which one reads [1].
    pub along: Vec3,
    /// Axis along which letters stand [1].
    pub up: Vec3,
    /// The extent along both [m].
    pub size: [f64; 2],
    /// Axis along or against one of them that points down on the printer [1].
    pub down: Vec3,
}

/// The word in capitals, raised on the face as large as it fits; none if it would be
/// lower than [`LOWEST`]. Symbols that the font does not have become question marks, with a warning.
pub fn word(word: &str, face: &Face) -> Option<Solid> {
    let (polygons, width) = outlines(&word.to_uppercase(), Weight::Bold);
    let room = [face.size[0] / (width + 2.0 * MARGIN), face.size[1] / (1.0 + 2.0 * MARGIN)];
    let height = room[0].min(room[1]).min(HIGHEST);
    if height < LOWEST {
        return None;
    }
    let centred = |p: &[f64; 2]| [(p[0] - width / 2.0) * height, (p[1] - 0.5) * height];
    let polygons: Vec<Vec<[f64; 2]>> =
        polygons.iter().map(|polygon| polygon.iter().map(centred).collect()).collect();
    let raised = RAISED.min(height / 10.0);
    let out = face.along.cross(&face.up) - face.down * SLANT;
    let place = Matrix3x4::from_columns(&[face.along, face.up, out, face.middle]);
    Some(Solid::extrude(&polygons, -raised, raised).transform(&place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::overhang::{CUSTOMARY, Overhangs, needs_supports};
    use mesh::SurfaceMesh;

    fn fitting(word: &str, face: &Face) -> Solid {
        super::word(word, face).expect("it fits")
    }

    #[test]
    fn the_thinnest_strokes_of_the_lowest_letters_can_be_printed() {
        // the bar of a hyphen is the thinnest
        let (polygons, _) = outlines("-", Weight::Bold);
        let level = |pick: fn(f64, f64) -> f64| {
            polygons[0].iter().map(|p| p[1]).reduce(pick).unwrap_or_default()
        };
        let stroke = (level(f64::max) - level(f64::min)) * LOWEST;
        assert!((0.4e-3..0.5e-3).contains(&stroke), "{stroke}");
    }

    #[test]
    fn letters_fit_the_face_and_each_is_one_body() {
        let middle = Vec3::new(1.0, 2.0, 3.0);
        let (along, up) = (Vec3::x(), Vec3::z());
        let face = Face { middle, along, up, size: [40e-3, 7e-3], down: -up };
        let solid = fitting("cup", &face);
        assert_eq!(solid.decompose().len(), 3);
        let (low, high) = solid.bounds();
        let half = [(high.x - low.x) / 2.0, (high.z - low.z) / 2.0];
        assert!(half[0] < 20e-3 && half[1] < 3.5e-3, "{half:?}");
        assert!((high.y - low.y - 2.0 * RAISED).abs() < 1e-12);
        // U has more of its strokes low.
        let u = fitting("u", &face);
        let half = u.trim_by_plane(&Vec3::z(), face.middle.z).volume();
        assert!(half < 0.5 * u.volume());
        let thin = Face { size: [40e-3, 2e-3], ..face };
        assert!(word("cup", &thin).is_none());
    }

    #[test]
    fn no_letter_hangs_over_however_the_face_is_printed() {
        let (along, up) = (Vec3::x(), Vec3::z());
        for down in [-up, up, along, -along] {
            let middle = Vec3::zeros();
            let face = Face { middle, along, up, size: [40e-3, 7e-3], down };
            let wall = Solid::cube(&Vec3::new(-0.02, 0.0, -4e-3), &Vec3::new(0.02, 5e-3, 4e-3));
            let solid = wall.union(&fitting("upper", &face)).to_surface();
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
