//! Shapes as they are written: millimetres in 32-bit floats, still valid solids.
//!
//! Rounding can spoil a surface. Where [`Rounded`] cannot repair it, the solid is simplified
//! first. Either way the surface must stay where it was.

use anyhow::{Result, bail};
use mesh::SurfaceMesh;
use mesh::check;
use mesh::measure::hausdorff;
use mesh::rounding::Rounded;
use mesh::solid::Solid;

use geometry::MM;
use geometry::frame::{Turn, moved};

/// Tolerances of simplification that are tried in turn [m].
const SIMPLIFY: [f64; 4] = [0.0, 1e-8, 1e-7, 1e-6];

/// Largest distance of a written surface from the solid, of which `fab verify` allows
/// five times as much between mold and design [mm].
const OFF: f64 = 1e-3;

/// The thickest needle that is taken out: a tenth of a micrometre [mm].
const THIN: f64 = 1e-4;

/// Points at which that distance is measured, besides the vertices.
const SAMPLES: usize = 20_000;

/// The boundary of `solid`, turned, in millimetres that 32-bit floats hold exactly.
pub fn printable(name: &str, solid: &Solid, turn: Turn) -> Result<SurfaceMesh> {
    let exact = turned(solid, turn);
    let mut findings = Vec::new();
    for tolerance in SIMPLIFY {
        let rounded = match tolerance {
            0.0 => Rounded::new(&exact, THIN),
            _ => Rounded::new(&turned(&solid.simplify(tolerance), turn), THIN),
        };
        if tolerance == 0.0 && !rounded.repaired {
            return Ok(rounded.surface);
        }
        findings = messages(&rounded.surface, &exact);
        if findings.is_empty() {
            return Ok(rounded.surface);
        }
        log::debug!("{name}: rounded it has {}", findings.join("; "));
    }
    bail!(
        "{name}: no valid surface within {} µm of the solid after rounding to 32-bit millimetres: {}; move the parting \
         a little, or mesh the design again",
        OFF * 1e3,
        findings.join("; ")
    );
}

/// What is wrong with a surface that was repaired.
fn messages(repaired: &SurfaceMesh, exact: &SurfaceMesh) -> Vec<String> {
    let mut found: Vec<String> =
        check::check_surface(repaired).into_iter().map(|finding| finding.message).collect();
    let off = hausdorff(repaired, exact, SAMPLES).max(hausdorff(exact, repaired, SAMPLES));
    if off > OFF {
        found.push(format!("it would be {:.3} µm off", off * 1e3));
    }
    found
}

/// The boundary of a solid, turned, in millimetres.
fn turned(solid: &Solid, turn: Turn) -> SurfaceMesh {
    moved(&solid.to_surface(), |p| turn.0 * p * MM)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::Vec3;

    #[test]
    fn repairs_leave_the_surface_where_it_was() {
        // Balls that differ by less than the resolution cut each other in thousands of needles.
        let centre = Vec3::new(0.05, 0.03, 0.02);
        let ball = |d: f64| Solid::sphere(&(centre + Vec3::repeat(d)), 0.01, 48);
        for d in [1e-10, 1e-9, 4e-9, 1e-8, 1e-7] {
            let solid = ball(0.0).union(&ball(d));
            let exact = turned(&solid, Turn::NONE);
            let written = printable("balls", &solid, Turn::lowering(-Vec3::z()));
            let written = written.unwrap_or_else(|error| panic!("{d}: {error}"));
            assert!(check::check_surface(&written).is_empty());
            assert!(written.vertices.iter().flatten().all(|x| *x == f64::from(*x as f32)));
            for (a, b) in [(&written, &exact), (&exact, &written)] {
                assert!(hausdorff(a, b, SAMPLES) <= OFF, "{d}: {}", hausdorff(a, b, SAMPLES));
            }
        }
    }
}
