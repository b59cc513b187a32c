//! Shapes as they are written: millimetres in 32-bit floats, still valid solids.
//!
//! Binary STL keeps 24 bits of a coordinate. Rounding can merge vertices and fold
//! needles over, so the rounded surface is welded and checked again before it is
//! written. If it is no longer valid, the needles that cross others are taken out one by
//! one; if that is not enough, the solid is simplified first. Either way
//! the surface must stay where it was.

mod needles;

use std::collections::{BTreeMap, BTreeSet};

use mesh::check;
use mesh::measure::hausdorff;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

use crate::geometry::MM;
use crate::geometry::frame::Turn;

/// Tolerances of simplification that are tried in turn [m].
const SIMPLIFY: [f64; 4] = [0.0, 1e-8, 1e-7, 1e-6];

/// Largest distance of a written surface from the solid, of which `fab verify` allows
/// five times as much between mold and design [mm].
const OFF: f64 = 1e-3;

/// Points at which that distance is measured, besides the vertices.
const SAMPLES: usize = 20_000;

/// No repair made the rounded surface valid without moving it.
#[derive(Debug, thiserror::Error)]
#[error(
    "{name}: no valid surface within {off_um} µm of the solid after rounding to 32-bit millimetres: {findings}; \
     move the parting or the design a little, or mesh the design anew",
    off_um = OFF * 1e3
)]
pub struct ExportError {
    name: String,
    findings: String,
}

/// The boundary of `solid`, turned, in millimetres that 32-bit floats hold exactly.
///
/// # Errors
/// [`ExportError`] if that is not a valid closed surface within a micrometre of the solid.
pub fn printable(name: &str, solid: &Solid, turn: Turn) -> Result<SurfaceMesh, ExportError> {
    let exact = solid.to_surface();
    let mut findings = Vec::new();
    for tolerance in SIMPLIFY {
        let mut rounded = match tolerance {
            0.0 => round(&exact, turn),
            _ => round(&solid.simplify(tolerance).to_surface(), turn),
        };
        let found = check::check_surface(&weld(&rounded));
        if found.is_empty() && tolerance == 0.0 {
            return Ok(weld(&rounded));
        }
        log::debug!("{name}: rounding leaves {}", found.first().map_or("nothing", |f| &f.message));
        needles::take_out(&mut rounded);
        let mut repaired = weld(&rounded);
        needles::take_out(&mut repaired);
        findings = messages(&repaired, &exact, turn);
        if findings.is_empty() {
            return Ok(repaired);
        }
        log::debug!("{name}: without needles it has {}", findings.join("; "));
    }
    Err(ExportError { name: name.into(), findings: findings.join("; ") })
}

/// What is wrong with a surface that was repaired.
fn messages(repaired: &SurfaceMesh, exact: &SurfaceMesh, turn: Turn) -> Vec<String> {
    let mut found: Vec<String> =
        check::check_surface(repaired).into_iter().map(|finding| finding.message).collect();
    let vertices = exact.vertices.iter().map(|p| turn.0 * p * MM).collect();
    let exact = SurfaceMesh { vertices, triangles: exact.triangles.clone() };
    let off = hausdorff(repaired, &exact, SAMPLES).max(hausdorff(&exact, repaired, SAMPLES));
    if off > OFF {
        found.push(format!("it would be {:.3} µm off", off * 1e3));
    }
    found
}

/// Rounds to 32-bit millimetres.
fn round(surface: &SurfaceMesh, turn: Turn) -> SurfaceMesh {
    // Adding zero turns -0 into +0.
    let rounded = |p: &Vec3| (turn.0 * p * MM).map(|x| f64::from(x as f32) + 0.0);
    let vertices = surface.vertices.iter().map(rounded).collect();
    SurfaceMesh { vertices, triangles: surface.triangles.clone() }
}

/// Makes one vertex of those that coincide, as whoever reads the file does, and nothing of
/// two triangles that lie upside down on each other.
fn weld(surface: &SurfaceMesh) -> SurfaceMesh {
    let mut vertices = Vec::new();
    let mut index = BTreeMap::new();
    let mut id = |v: usize| {
        let p = surface.vertices[v];
        *index.entry([p.x, p.y, p.z].map(f64::to_bits)).or_insert_with(|| {
            vertices.push(p);
            vertices.len() - 1
        })
    };
    let triangles = surface.triangles.iter().map(|t| t.map(&mut id));
    let mut triangles: Vec<[usize; 3]> =
        triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let from_least = |mut t: [usize; 3]| {
        let least = (0..3).min_by_key(|&k| t[k]).unwrap_or_default();
        t.rotate_left(least);
        t
    };
    let all: BTreeSet<[usize; 3]> = triangles.iter().map(|t| from_least(*t)).collect();
    triangles.retain(|&[a, b, c]| !all.contains(&from_least([a, c, b])));
    SurfaceMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn repairs_leave_the_surface_where_it_was() {
        // Balls that differ by less than the resolution cut each other in thousands of needles.
        let centre = Vec3::new(0.05, 0.03, 0.02);
        let ball = |d: f64| Solid::sphere(&(centre + Vec3::repeat(d)), 0.01, 48);
        for d in [1e-10, 1e-9, 4e-9, 1e-8, 1e-7] {
            let solid = ball(0.0).union(&ball(d));
            let surface = solid.to_surface();
            let vertices = surface.vertices.iter().map(|p| p * MM).collect();
            let exact = SurfaceMesh { vertices, triangles: surface.triangles };
            let written = printable("balls", &solid, Turn::lowering(-Vec3::z()));
            let written = written.unwrap_or_else(|error| panic!("{d}: {error}"));
            assert!(check::check_surface(&written).is_empty());
            for (a, b) in [(&written, &exact), (&exact, &written)] {
                assert!(hausdorff(a, b, SAMPLES) <= OFF, "{d}: {}", hausdorff(a, b, SAMPLES));
            }
        }
    }

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
