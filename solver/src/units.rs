//! Units in which people measure.

use std::f64::consts::PI;

use anyhow::{Context, Result};

/// Names of units, and how much one is.
type Units = &'static [(&'static str, f64)];

/// The units of each quantity, by the one in which programs have it.
const ALL: [(&str, Units); 8] = [
    ("1", &[("1", 1.0), ("-", 1.0), ("mm/mm", 1.0), ("m/m", 1.0), ("%", 0.01), ("percent", 0.01)]),
    ("m", &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6)]),
    ("m³", &[("m³", 1.0), ("m3", 1.0), ("l", 1e-3), ("ml", 1e-6), ("cm3", 1e-6), ("cm³", 1e-6)]),
    ("1/m", &[("1/m", 1.0), ("1/mm", 1e3)]),
    ("deg", &[("deg", 1.0), ("°", 1.0), ("rad", 180.0 / PI)]),
    ("kg", &[("kg", 1.0), ("g", 1e-3)]),
    ("N", &[("N", 1.0), ("mN", 1e-3), ("kN", 1e3)]),
    ("Pa", STRESSES),
];

const STRESSES: Units = &[
    ("Pa", 1.0),
    ("kPa", 1e3),
    ("MPa", 1e6),
    // pound-force 4.448 221 615 260 5 N on a square of 25.4 mm
    ("psi", 4.448_221_615_260_5 / (0.0254 * 0.0254)),
    ("N/m2", 1.0),
    ("N/m²", 1.0),
    ("N/mm2", 1e6),
    ("N/mm²", 1e6),
    ("N/mm^2", 1e6),
];

/// How much one of a unit is in that of programs.
pub fn factor(own: &str, wanted: &str) -> Result<f64> {
    let known = ALL.iter().find(|(unit, _)| *unit == wanted).map_or(&[][..], |(_, known)| known);
    let found = known.iter().find(|(unit, _)| *unit == own).map(|(_, factor)| *factor);
    let names = || known.iter().map(|(unit, _)| *unit).collect::<Vec<_>>().join(", ");
    found.with_context(|| {
        format!("the unit \"{own}\" is no multiple of {wanted}: expected one of {}", names())
    })
}
