//! Implicit models: primitives and smooth blends → closed surface and regions.
//!
//! The surface is the zero level of max(d_solid, −d_cavity), laid by marching
//! tetrahedra and simplified; planar faces are cut afterwards, so that they are
//! planar to the last bit.

mod field;
mod model;
mod region;
mod shape;

use anyhow::{Result, ensure};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

pub use field::Field;
pub use model::{Cuboid, Cut, Model, ModelFile, Op, Primitive, Region};
pub use region::assign;
pub use shape::{Rotation, Shape};

/// The two implicit functions of a model.
pub struct Fields {
    /// The body with its cavities filled.
    pub solid: Field,
    /// What is taken out.
    pub cavity: Field,
}

impl Fields {
    /// The functions of `model`, with its ornaments if `fine`.
    #[must_use]
    pub fn new(model: &Model, fine: bool) -> Self {
        Self { solid: Field::new(&model.solid, fine), cavity: Field::new(&model.cavity, fine) }
    }
}

/// The closed surface of a model [unit of the file].
///
/// # Errors
/// If nothing is left of the body or if it falls into pieces.
pub fn surface(model: &Model, fields: &Fields) -> Result<SurfaceMesh> {
    let distance = |p: Vec3| fields.solid.at(&p).max(-fields.cavity.at(&p));
    let mut solid = Solid::level_set(distance, model.bounds(), model.grid)?;
    if model.simplify > 0.0 {
        solid = solid.simplify(model.simplify);
    }
    for cut in &model.cut {
        solid = solid.trim_by_plane(&-Vec3::from(cut.normal), -cut.offset);
    }
    ensure!(!solid.is_empty(), "nothing is left of the body: do its primitives lie behind a cut?");
    let pieces = solid.decompose().len();
    ensure!(
        pieces == 1,
        "the body falls into {pieces} pieces; it must be one: join its primitives"
    );
    let mut surface = solid.to_surface();
    for cut in &model.cut {
        snap(&mut surface, cut, model.grid * 1e-6);
    }
    Ok(surface)
}

/// Moves vertices that rounding has put beside the plane of a cut onto it.
fn snap(surface: &mut SurfaceMesh, cut: &Cut, tolerance: f64) {
    let normal = Vec3::from(cut.normal).normalize();
    for v in &mut surface.vertices {
        let beside = normal.dot(v) - cut.offset;
        if beside.abs() <= tolerance {
            *v -= normal * beside;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::check::check_surface;
    use mesh::measure::{enclosed_volume, triangle_area};

    /// A dome with a bore from its flat base into a round chamber.
    const DOME: &str = "
        unit = 'mm'
        grid = 0.5
        [[solid]]
        name = 'dome'
        shape.sphere = { center = [0, 0, 0], radius = 6 }
        [[solid]]
        name = 'knob'
        shape.sphere = { center = [0, 0, 6], radius = 2 }
        [[cavity]]
        name = 'chamber'
        shape.sphere = { center = [0, 0, 2.5], radius = 2 }
        [[cavity]]
        name = 'bore'
        shape.cylinder = { from = [0, 0, -1], to = [0, 0, 2], radius = 1 }
        [[cut]]
        name = 'floor'
        normal = [0, 0, -2]
        offset = 0
        [[region]]
        name = 'base'
        cut = 'floor'
        [[region]]
        name = 'cavity'
        cavity = true
        [[region]]
        name = 'top'
        primitives = ['knob']
        [[region]]
        name = 'left'
        within = { min = [-9, 0, 0], max = [9, 9, 9] }
        [[region]]
        name = 'skin'
        rest = true";

    #[test]
    fn a_dome_is_closed_cut_exactly_and_fully_assigned() {
        let model = toml::from_str::<Model>(DOME).unwrap();
        let fields = Fields::new(&model, false);
        let surface = surface(&model, &fields).unwrap();
        assert_eq!(check_surface(&surface), vec![]);

        let regions = assign(&model, &fields, &surface);
        let (mut areas, mut lowest) = ([0.0; 5], [f64::INFINITY; 5]);
        for (t, region) in regions.iter().enumerate() {
            let [a, b, c] = surface.corners(t);
            areas[region.unwrap()] += triangle_area(a, b, c);
            lowest[region.unwrap()] = lowest[region.unwrap()].min(surface.centroid(t).z);
            if region.unwrap() == 0 {
                assert!([a, b, c].iter().all(|p| p.z == 0.0), "{a} {b} {c}");
            }
        }
        // Chords of length h under-estimate areas by about (h/r)²/10: 2 % at the bore.
        let pi = std::f64::consts::PI;
        for (region, exact) in
            [(0, 35.0 * pi), (1, 4.0 * pi * 4.0 - 2.0 * pi * 2.0 * 0.268 + 2.0 * pi * 0.768)]
        {
            let off = areas[region] / exact - 1.0;
            assert!(off.abs() < 0.03, "region {region}: area {} vs {exact}", areas[region]);
        }
        assert!(lowest[2] > 5.0, "the knob reaches down to {}", lowest[2]);
        // Triangles on the seam, 19 mm long, go to either side: up to 19 h/4 mm² of 106.
        assert!((areas[3] / areas[4] - 1.0).abs() < 0.05, "halves {} {}", areas[3], areas[4]);

        let dome = 2.0 / 3.0 * pi * 216.0;
        let air = 4.0 / 3.0 * pi * 8.0 + pi * 0.768;
        let (volume, knob) = (enclosed_volume(&surface), 4.0 / 3.0 * pi * 8.0 / 2.0);
        assert!((dome - air..dome - air + knob * 1.5).contains(&volume), "volume {volume}");
    }

    #[test]
    fn loose_pieces_are_refused() {
        let apart = DOME.replace("center = [0, 0, 6]", "center = [0, 0, 20]");
        let model = toml::from_str::<Model>(&apart).unwrap();
        let message = surface(&model, &Fields::new(&model, false)).unwrap_err().to_string();
        assert!(message.contains("2 pieces"), "{message}");
    }
}
