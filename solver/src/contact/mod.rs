//! Distances between surfaces and what is built on them: barriers and sums
//! over the pairs of features that are close.
//!
//! Source: Li et al. 2020, "Incremental Potential Contact",
//! doi:10.1145/3386569.3392425.

pub mod distance; // of two features
pub mod mollifier; // where edges are parallel
pub mod barrier; // as a function of distance
pub mod pairs; // of features
pub mod box_tree; // which boxes overlap
pub mod candidates; // what may come close in a step
pub mod ccd; // how far it may move
pub mod friction; // lagged to the start of a time step
pub mod potential; // of a rest shape
pub mod surface; // what collides
pub mod stencil; // what one pair adds
pub mod weights; // areas
pub mod terms; // the potential of a surface
pub mod certificate; // that nothing intersects
