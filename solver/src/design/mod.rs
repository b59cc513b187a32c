//! From design variables to rest shape and loads, each map with its transposed derivative:
//! free-form deformation of surfaces by handles with bounded biharmonic weights, an
//! extension into the interior, and schedules of pressures.

pub mod biharmonic;
mod carry;
mod design_map;
pub mod geodesic;
mod handles;
mod held;
mod isometry;
mod laplacian;
mod load_map;
mod motion;
mod patch;
mod pressure_curve;
pub mod sampling;
mod scalar;
mod swelling;

pub use carry::{Carried, carry, check_same_body};
pub use design_map::DesignMap;
pub use geodesic::Geodesics;
pub use handles::{HandleError, Handles, sample_handles};
pub use held::{Flat, Held};
pub use isometry::Isometry;
pub use load_map::{LoadMap, LoadVariable};
pub use patch::{FreeVertices, Patch};
pub use pressure_curve::PressureCurve;
pub use scalar::Scalar;
