//! From design variables to rest shape, each map with its transpose.

pub mod biharmonic;
mod extension;
pub mod geodesic;
mod handles;
mod laplacian;
mod patch;
mod pressure_curve;
pub mod sampling;
mod scalar;

pub use extension::Extension;
pub use geodesic::Geodesics;
pub use handles::{HandleError, Handles, sample_handles};
pub use patch::{FreeVertices, Patch};
pub use pressure_curve::PressureCurve;
pub use sampling::Sweeps;
pub use scalar::Scalar;
