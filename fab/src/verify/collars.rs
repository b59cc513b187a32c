//! A tube is gripped by its collar.
//!
//! Measured half-way along the collar, on a slice of height h: the core there has the
//! diameter d = 2 √(V / π h) of the bore, and the silicone around it a wall of
//! (D − d) / 2, D likewise.

use mesh::solid::Solid;

use super::Line;
use super::closed_mold::ClosedMold;
use crate::geometry::MM;
use crate::mold::Purpose;

/// Least and largest part of its diameter by which a tube is squeezed: judgements.
const SQUEEZED: [f64; 2] = [0.02, 0.4];

/// The slice that is measured, in parts of the collar's length.
const SLICE: [f64; 2] = [0.45, 0.55];

/// A core without its bore for water.
fn filled(mold: &ClosedMold, core: &Solid) -> Solid {
    let drains = mold.report.features.iter().filter(|f| f.purpose == Purpose::Drain);
    drains.fold(core.clone(), |all, drain| all.union(&drain.exact()))
}

/// All checks of collars.
pub fn checks(mold: &ClosedMold) -> Vec<Line> {
    let shrinks = mold.report.scale() / MM;
    let mut lines = Vec::new();
    for (i, tube) in mold.report.collars.iter().enumerate() {
        let collar = tube.collar();
        let slice = collar.slice(SLICE[0], SLICE[1]);
        let height = collar.length * (SLICE[1] - SLICE[0]);
        let area = |solid: &Solid| slice.intersection(solid).volume() / height;
        let bore: f64 = mold.cores.iter().map(|core| area(&filled(mold, &core.solid))).sum();
        let diameter = |area: f64| 2.0 * (area / std::f64::consts::PI).sqrt() / shrinks;
        let inside = diameter(bore);
        let wall = (diameter(bore + area(&mold.cast.solid)) - inside) / 2.0;
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
