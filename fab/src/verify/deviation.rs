//! How far surfaces are from each other, in the millimetres of the mold.

use geometry::frame::moved;
use mesh::bvh::SurfaceBvh;
use mesh::inside::WindingNumber;
use mesh::{SurfaceMesh, Vec3};

use crate::files::report::MoldReport;

/// Largest distance between the cast and the surface that is to be cast, besides rounding: a thirtieth
/// of what filament printers are off by, and above the 3 µm between chamber and sheet [mm].
pub const SURFACE: f64 = 5e-3;

/// Part of its radius by which a ball that fits into a body may be smaller, for rounding.
const ROUND: f64 = 0.99;

/// A surface of the design, in the mold's millimetres.
pub fn placed(surface: &SurfaceMesh, report: &MoldReport) -> SurfaceMesh {
    let row = |r: [f64; 4], p: &Vec3| r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3];
    moved(surface, |p| Vec3::from(report.design_to_mold.map(|r| row(r, p))))
}

/// Largest distance of `from` to `to`, without films thinner than `film`: where
/// parts touch, rounding leaves gaps of a few nanometres that can be connected
/// with the body.
///
/// Measured at the centroid of each triangle and near its corners. A place far
/// from `to` belongs to a film if no ball of the diameter `film` fits into `from` below it.
///
/// What this lets through is measured on damaged parts in `tests/films.rs`. Places that are not `counted` do not count.
/// Returns the distance and its place.
pub fn deviation(
    from: &SurfaceMesh,
    to: &SurfaceMesh,
    film: f64,
    counted: impl Fn(&Vec3) -> bool,
) -> (f64, Vec3) {
    const NEAR_CORNER: f64 = 0.9;
    let bvh = SurfaceBvh::new(to);
    let inside = WindingNumber::new(from);
    let own = SurfaceBvh::new(from);
    let mut worst = (0.0, Vec3::zeros());
    for t in 0..from.triangles.len() {
        let [a, b, c] = from.corners(t);
        if from.area(t) == 0.0 {
            continue;
        }
        let below = from.normal(t) * film;
        // The ball itself, and one as deep again: near an edge the first may not fit.
        let is_thick = |p: &Vec3| {
            [0.5, 1.0].into_iter().map(|depth| p - below * depth).any(|middle| {
                own.closest(&middle).distance >= ROUND * film / 2.0 && inside.contains(&middle)
            })
        };
        let centre = from.centroid(t);
        let near = [a, b, c].map(|corner| centre + (corner - centre) * NEAR_CORNER);
        for p in near.into_iter().chain([centre]) {
            let distance = bvh.closest(&p).distance;
            if distance > worst.0 && counted(&p) && (distance <= film || is_thick(&p)) {
                worst = (distance, p);
            }
        }
    }
    worst
}
