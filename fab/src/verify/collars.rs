//! A tube is gripped by its collar.
//!
//! Measured half-way along the collar, in a slice of the mold cavity: the nearest place of the
//! silicone to the collar's axis is on its bore, the farthest on its outside. A casting that ends before a collar
//! does not have it; one that is cut along its axis has a half.

use geometry::MM;
use mesh::Vec3;
use mesh::solid::Solid;

use super::Line;
use super::closed_mold::ClosedMold;
use crate::body::collar::Collar;
use crate::body::source::CastPart;

/// Least and largest part of its diameter by which a tube is squeezed: judgements.
const SQUEEZED: [f64; 2] = [0.02, 0.4];

/// The slice that is measured, in parts of the collar's length.
const SLICE: [f64; 2] = [0.45, 0.55];

/// Whether a casting has at least a part of a slice.
fn belongs(part: &CastPart, slice: &Solid) -> bool {
    match part {
        CastPart::Above(height) => !slice.trim_by_plane(&Vec3::z(), *height).is_empty(),
        CastPart::Below(height) => !slice.trim_by_plane(&-Vec3::z(), -height).is_empty(),
        CastPart::Whole => true,
    }
}

/// Radii of the bore and of the outside in a slice of what is cast; a bore without silicone around it has
/// no radius [mm].
fn radii(slice: &Solid, mold: &ClosedMold, collar: &Collar) -> [f64; 2] {
    // Without the bore for water in its core.
    let ring = slice.intersection(&mold.cavity).difference(&mold.channels).to_surface();
    let along = collar.axis.normalize();
    let radius = |p: &Vec3| {
        let from = p - collar.base;
        (from - along * from.dot(&along)).norm()
    };
    let all = || ring.vertices.iter().map(radius);
    let nearest = all().fold(f64::INFINITY, f64::min);
    [if nearest.is_finite() { nearest } else { 0.0 }, all().fold(0.0, f64::max)]
}

/// All checks of collars.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let shrinks = mold.report.scale() / MM;
    let mut lines = Vec::new();
    for (i, tube) in mold.report.collars.iter().enumerate() {
        let collar = tube.collar();
        let slice = collar.slice(SLICE[0], SLICE[1]);
        if !belongs(&mold.report.input.part, &slice) {
            continue;
        }
        let [bore, outside] = radii(&slice, mold, &collar).map(|r| r / shrinks);
        let (inside, wall) = (2.0 * bore, outside - bore);
        let squeezed = 1.0 - inside / tube.outer;
        let [least, most] = SQUEEZED;
        lines.push(Line::new(
            format!("collar {}: grips", i + 1),
            (least..=most).contains(&squeezed),
            format!("{inside:.2} mm for a tube of {:.2} mm, {:.1} %", tube.outer, 100.0 * squeezed),
            &format!("{:.0} to {:.0} % narrower", 100.0 * least, 100.0 * most),
        ));
        let least = mold.report.casting.least_wall * MM;
        // A polygon is narrower than its circle, and both are rounded.
        let name = format!("collar {}: wall", i + 1);
        lines.push(Line::at_least(name, wall, 0.999 * least - 2.0 * mold.rounding, "mm"));
    }
    lines
}
