//! Walls that are too thin to be cast.

use mesh::measure::diagonal;
use mesh::walls;
use mesh::{SurfaceMesh, Vec3};

/// Thicknesses that differ by less are equal: what files of a hand-sized mold resolve [m].
pub const ROUNDING: f64 = 1e-8;

/// A mesh is within this part of the diagonal of the model that it was made from: envelopes of a tenth of
/// a wall are that wide in small bodies.
pub const OFF: f64 = 1e-2;

/// The thinnest wall of a body and where it begins: of its model and of what it has beside that, such as
/// collars; without a model, of the surface itself.
#[must_use]
pub fn thinnest(surface: &SurfaceMesh, model: Option<&SurfaceMesh>) -> Option<(f64, Vec3)> {
    match model {
        Some(model) => walls::thinnest_with(surface, model, OFF * diagonal(&model.vertices)),
        None => walls::thinnest(surface),
    }
}

/// On what a wall was measured, in words.
#[must_use]
pub fn measured_on(model: Option<&SurfaceMesh>) -> &'static str {
    if model.is_some() { "model" } else { "mesh" }
}

/// The thinnest wall and where it begins [m], if it is thinner than `least` [m].
#[must_use]
pub fn too_thin(
    surface: &SurfaceMesh,
    model: Option<&SurfaceMesh>,
    least: f64,
) -> Option<(f64, Vec3)> {
    thinnest(surface, model).filter(|(thickness, _)| *thickness < least - ROUNDING)
}
