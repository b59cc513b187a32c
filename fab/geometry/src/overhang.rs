//! Overhangs: the areas of a part that face down when it is printed.

use mesh::{SurfaceMesh, measure};

/// Steepest overhang of an unnamed printer, from the vertical [degrees].
pub const CUSTOMARY: f64 = 45.0;

/// Facets this near to the lowest point lie on the bed: a quarter of a layer [mm].
const BED: f64 = 0.05;

/// Rounding of a normal's sine: slopes of just the steepest angle do not hang.
const SINE_ROUNDING: f64 = 1e-6;

/// A bead of molten plastic holds itself where less hangs in all: one square as wide as a
/// line and a half of a 0.4 mm nozzle [mm²].
const SELF_SUPPORTING: f64 = 0.5;

/// Areas that face down [mm²].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overhangs {
    /// On the printer's bed.
    pub bed: f64,
    /// Beyond the steepest overhang and above the bed.
    pub hanging: f64,
    /// That part of what hangs which shapes the silicone, where supports leave scars.
    pub shaping: f64,
}

impl Overhangs {
    /// Overhangs of a part as it lies in its file [mm], printed with overhangs of up to
    /// `steepest` from the vertical [degrees]; `shapes` says which facets shape the silicone.
    pub fn new(printed: &SurfaceMesh, steepest: f64, shapes: impl Fn(usize) -> bool) -> Self {
        let bed = measure::bounds(&printed.vertices).0.z + BED;
        // A facet at the angle a from the vertical has a normal with z = −sin a.
        let limit = -steepest.to_radians().sin() - SINE_ROUNDING;
        let mut found = Self::default();
        for t in 0..printed.triangles.len() {
            if printed.normal(t).z >= limit {
                continue;
            }
            let area = printed.area(t);
            if printed.centroid(t).z <= bed {
                found.bed += area;
            } else {
                found.hanging += area;
                found.shaping += if shapes(t) { area } else { 0.0 };
            }
        }
        found
    }
}

/// Whether that much hanging area needs supports [mm²].
pub fn needs_supports(hanging: f64) -> bool {
    hanging > SELF_SUPPORTING
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::Vec3;
    use mesh::solid::Solid;

    #[test]
    fn ceilings_hang_and_slopes_do_not() {
        // A table: its top of 20 × 20 mm hangs over a foot of 4 × 4 mm.
        let foot = Solid::cube(&Vec3::new(-2.0, -2.0, 0.0), &Vec3::new(2.0, 2.0, 10.0));
        let top = Solid::cube(&Vec3::new(-10.0, -10.0, 10.0), &Vec3::new(10.0, 10.0, 12.0));
        let table = Overhangs::new(&foot.union(&top).to_surface(), CUSTOMARY, |_| false);
        assert!((table.bed - 16.0).abs() < 1e-9 && (table.hanging - 384.0).abs() < 1e-9);
        assert!(needs_supports(table.hanging) && table.shaping == 0.0, "{table:?}");
        // A cone that widens by 40° and one by 50°.
        for (degrees, hangs) in [(40.0_f64, false), (50.0, true)] {
            let wide = 2.0 + 10.0 * degrees.to_radians().tan();
            let cone = Solid::cylinder(&Vec3::zeros(), &(Vec3::z() * 10.0), 2.0, wide, 96);
            let cone = Overhangs::new(&cone.to_surface(), CUSTOMARY, |_| true);
            assert_eq!(needs_supports(cone.shaping), hangs, "{cone:?}");
        }
    }
}
