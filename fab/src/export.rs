//! Shapes as they are written: millimetres in 32-bit floats, still valid solids.
//!
//! Binary STL keeps 24 bits of a coordinate. Rounding can merge vertices and fold
//! slivers over, so the rounded surface is welded and checked again before it is
//! written; if it is no longer valid, the solid is simplified, a little more each
//! time, until it is.

use std::collections::BTreeMap;

use mesh::SurfaceMesh;
use mesh::check;
use mesh::solid::Solid;

use crate::frame::Turn;

/// Millimetres per metre.
pub const MM: f64 = 1e3;

/// Tolerances of simplification that are tried in turn [m].
const SIMPLIFY: [f64; 4] = [0.0, 1e-8, 1e-7, 1e-6];

/// No simplification made the rounded surface valid.
#[derive(Debug, thiserror::Error)]
#[error(
    "{name}: not a valid surface after rounding to 32-bit millimetres, even when simplified by {tolerance_um} µm: {findings}"
)]
pub struct ExportError {
    name: String,
    tolerance_um: f64,
    findings: String,
}

/// The boundary of `solid`, turned, in millimetres that 32-bit floats hold exactly.
///
/// # Errors
/// [`ExportError`] if that is not a valid closed surface.
pub fn printable(name: &str, solid: &Solid, turn: Turn) -> Result<SurfaceMesh, ExportError> {
    let mut findings = Vec::new();
    for tolerance in SIMPLIFY {
        let surface = match tolerance {
            0.0 => solid.to_surface(),
            _ => solid.simplify(tolerance).to_surface(),
        };
        let rounded = round(&surface, turn);
        findings = check::check_surface(&rounded);
        if findings.is_empty() {
            return Ok(rounded);
        }
        log::debug!("{name}: rounding leaves {}", findings[0].message);
    }
    let findings: Vec<String> = findings.into_iter().map(|f| f.message).collect();
    Err(ExportError {
        name: name.into(),
        tolerance_um: SIMPLIFY[SIMPLIFY.len() - 1] * 1e6,
        findings: findings.join("; "),
    })
}

/// Rounds to 32-bit millimetres and makes one vertex of those that coincide.
fn round(surface: &SurfaceMesh, turn: Turn) -> SurfaceMesh {
    let mut vertices = Vec::new();
    let mut index = BTreeMap::new();
    let ids: Vec<usize> = surface
        .vertices
        .iter()
        .map(|p| {
            // Adding zero turns -0 into +0.
            let p = (turn.0 * p * MM).map(|x| f64::from(x as f32) + 0.0);
            *index.entry([p.x, p.y, p.z].map(f64::to_bits)).or_insert_with(|| {
                vertices.push(p);
                vertices.len() - 1
            })
        })
        .collect();
    let triangles = surface.triangles.iter().map(|t| t.map(|v| ids[v]));
    let triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    SurfaceMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::Vec3;

    #[test]
    fn slivers_below_the_resolution_are_repaired() {
        // A notch of 10⁻⁹ m in a cube 50 mm away from the origin: its vertices
        // fall together in 32 bits, where one unit is 4·10⁻⁹ m.
        let corner = Vec3::repeat(0.05);
        let cube = Solid::cube(&corner, &(corner + Vec3::repeat(0.01)));
        let notch =
            Solid::cube(&(corner - Vec3::repeat(1e-3)), &(corner + Vec3::new(1e-9, 5e-3, 5e-3)));
        let written = printable("cube", &cube.difference(&notch), Turn::lowering(Vec3::y()));
        let written = written.unwrap();
        assert!(check::check_surface(&written).is_empty());
        assert!((mesh::measure::enclosed_volume(&written) - 1e3).abs() < 1e-3);
        for x in written.vertices.iter().flatten() {
            assert_eq!(*x, f64::from(*x as f32));
        }
    }
}
