//! The surface of a body as it is kept.

use mesh::SurfaceMesh;
use serde::Serialize;

/// What a triangle of the surface is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The outside of the solid.
    Outside,
    /// The wall of a cavity.
    Cavity,
    /// The face of a cut, by its index.
    Cut(usize),
}

/// The closed surface of a body, as binary STL keeps it.
#[derive(Clone)]
pub struct Skin {
    /// The surface [m].
    pub surface: SurfaceMesh,
    /// What each triangle is a part of.
    pub part: Vec<Part>,
    /// Where the body is thinner than the finest cell, the thinnest first.
    pub thin: Vec<Thin>,
}

/// What is thin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The body itself.
    Wall,
    /// A groove, or the space between two parts of the body.
    Gap,
}

/// A place that is thinner than the finest cell.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Thin {
    /// What is thin.
    pub kind: Kind,
    /// Whether the surface has both of its sides; else a gap is closed and a wall is missing there.
    pub resolved: bool,
    /// [m]
    pub thickness: f64,
    /// [m]
    pub at: [f64; 3],
}
