//! Distances between surfaces and what is built on them: barriers and sums
//! over the pairs of features that are close.
//!
//! Source: Li et al. 2020, "Incremental Potential Contact",
//! doi:10.1145/3386569.3392425.

pub mod barrier;
mod box_tree;
pub mod candidates;
pub mod ccd;
pub mod distance;
pub mod friction;
pub mod mollifier;
pub mod pairs;
pub mod potential;
pub mod stencil;
pub mod surface;
pub mod terms;
pub mod weights;
