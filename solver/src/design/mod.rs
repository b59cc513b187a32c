//! From design variables to rest shape, each map with its transpose.

pub mod biharmonic;
mod extension;
pub mod geodesic;
mod handles;
mod laplacian;
pub mod sampling;

pub use extension::Extension;
pub use geodesic::Geodesics;
pub use handles::{HandleError, Handles, sample_handles};
