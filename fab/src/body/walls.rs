//! Walls that are too thin to be cast.

use mesh::measure::diagonal;
use mesh::walls;
use mesh::{SurfaceMesh, Vec3};

use crate::config::Casts;

/// Thicknesses that differ by less are equal: what files of a hand-sized mold resolve [m].
pub const THICKNESS_ROUNDING: f64 = 1e-8;

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

impl Wall {
    /// Whether it is thinner than `least` [m].
    pub fn is_thinner(&self, least: f64) -> bool {
        self.thickness < least - THICKNESS_ROUNDING
    }
}

/// The thinnest wall of what is cast, the surface of a model or of a mesh, and of the other one with what is cast
/// beside it, such as collars.
///
/// A wall that is thin is thin on the model and on the mesh. What only one of them shows is a facet that
/// stands askew, or an edge that was cut off: the thicker of the two measures counts.
pub fn thinnest(
    (surface, casts): (&SurfaceMesh, Casts),
    other: Option<&SurfaceMesh>,
) -> Option<Wall> {
    let name = |casts: Casts| if casts == Casts::Mesh { "mesh" } else { "model" };
    let on = |casts: Casts| move |(thickness, at)| Wall { thickness, at, on: name(casts) };
    let cast = walls::thinnest(surface).map(on(casts));
    let Some(other) = other else { return cast };
    let limit = OFF * diagonal(&other.vertices);
    let other = walls::thinnest_with(surface, other, limit).map(on(casts.other()));
    // Where both are equal, the model is named.
    let least = if casts == Casts::Mesh { THICKNESS_ROUNDING } else { -THICKNESS_ROUNDING };
    match (other, cast) {
        (Some(other), Some(cast)) if cast.thickness > other.thickness + least => Some(cast),
        (other, cast) => other.or(cast),
    }
}

/// The thinnest wall, if it is thinner than `least` [m].
pub fn too_thin(
    surface: (&SurfaceMesh, Casts),
    other: Option<&SurfaceMesh>,
    least: f64,
) -> Option<Wall> {
    thinnest(surface, other).filter(|wall| wall.is_thinner(least))
}
