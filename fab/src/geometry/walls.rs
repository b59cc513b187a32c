//! Walls that are too thin to be cast.

use mesh::measure::diagonal;
use mesh::walls;
use mesh::{SurfaceMesh, Vec3};

/// Thicknesses that differ by less are equal: what files of a hand-sized mold resolve [m].
pub const ROUNDING: f64 = 1e-8;

/// A mesh is within this part of the diagonal of the model that it was made from: envelopes of a tenth of
/// a wall are that wide in small bodies.
pub const OFF: f64 = 1e-2;

/// The thinnest wall of a body.
#[derive(Clone, Copy, Debug)]
pub struct Wall {
    /// How thick it is [m].
    pub thickness: f64,
    /// Where it begins [m].
    pub at: Vec3,
    /// On what it was measured: "model" or "mesh".
    pub on: &'static str,
}

/// The thinnest wall of a surface, of its model and of what it has beside that, such as collars.
///
/// A wall that is thin is thin on the model and on the mesh. What only one of them shows is a facet that
/// stands askew, or an edge that was cut off: the thicker of the two measures counts.
#[must_use]
pub fn thinnest(surface: &SurfaceMesh, model: Option<&SurfaceMesh>) -> Option<Wall> {
    let on = |name| move |(thickness, at)| Wall { thickness, at, on: name };
    let mesh = walls::thinnest(surface).map(on("mesh"));
    let Some(model) = model else { return mesh };
    let limit = OFF * diagonal(&model.vertices);
    let model = walls::thinnest_with(surface, model, limit).map(on("model"));
    match (model, mesh) {
        (Some(model), Some(mesh)) if mesh.thickness > model.thickness + ROUNDING => Some(mesh),
        (model, mesh) => model.or(mesh),
    }
}

/// The thinnest wall, if it is thinner than `least` [m].
#[must_use]
pub fn too_thin(surface: &SurfaceMesh, model: Option<&SurfaceMesh>, least: f64) -> Option<Wall> {
    thinnest(surface, model).filter(|wall| wall.thickness < least - ROUNDING)
}
