//! Contact mechanics: distances between surfaces, and the potentials, bounds on steps
//! and proofs that are built on them.
//!
//! Source: Li et al. 2020, "Incremental Potential Contact" (IPC),
//! doi:10.1145/3386569.3392425.

pub mod distance; // of two features
pub mod mollifier; // where edges are parallel
pub mod density; // log barrier or quadratic, of a distance
pub mod barrier; // the one that bodies are simulated with
pub mod pairs; // of features
pub mod rest_offset; // activations of pairs that are close at rest
pub mod box_tree; // which boxes overlap
pub mod candidates; // broad phase: what may come close in a step
pub mod ccd; // continuous collision detection: how far it may move
pub mod rest_potential; // of one shape
pub mod images; // in planes of symmetry
pub mod surface; // what collides
pub mod solid; // what lies between the features of a pair at rest
pub mod stencil; // what one pair adds
pub mod weights; // areas
pub mod terms; // weighted stencils of a surface
pub mod potential; // their sum, with every derivative
pub mod neighbours; // candidates that are kept
pub mod friction; // lagged to the start of a time step
pub mod certificate; // that nothing intersects
