//! Meshes, tags, validity checks and file formats, shared by all stages.
//!
//! Lengths are metres. Triangles are counter-clockwise seen from outside,
//! tetrahedra have positive volume, indices start at zero.

pub mod bvh;
pub mod check;
pub mod crossings;
pub mod faces;
pub mod improve;
pub mod inside;
pub mod io;
pub mod measure;
pub mod offset;
pub mod predicates;
pub mod rounding;
pub mod solid;
pub mod topology;
pub mod walls;

pub mod needles;
mod places;
mod surface;
mod tags;
mod tet;

pub use places::{first_at_place, place_key, triangle_key, welded};
pub use surface::SurfaceMesh;
pub use tags::{Tags, Volumes, facet_key};
pub use tet::TetMesh;

/// A point or a vector [m].
pub type Vec3 = nalgebra::Vector3<f64>;
