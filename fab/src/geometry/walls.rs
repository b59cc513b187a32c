//! Walls that are too thin to be cast.

use mesh::walls::thinnest;
use mesh::{SurfaceMesh, Vec3};

/// Thicknesses that differ by less are equal: what files of a hand-sized mold resolve [m].
pub const ROUNDING: f64 = 1e-8;

/// The thinnest wall and where it begins [m], if it is thinner than `least` [m].
#[must_use]
pub fn too_thin(surface: &SurfaceMesh, least: f64) -> Option<(f64, Vec3)> {
    thinnest(surface).filter(|(thickness, _)| *thickness < least - ROUNDING)
}
