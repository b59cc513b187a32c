//! Scenes: what people write, and the bodies, laws, supports and loads that it stands for.
//!
//! Modules in dependency order; each uses only those before it:

pub mod memory; // what the machine has left
pub mod law_table; // laws of materials as tables
pub mod silicone; // known materials
pub mod meaning; // what errors of the mechanics mean for it
pub mod supports; // Dirichlet conditions: fixed degrees of freedom
pub mod term; // terms of the energy, a room each
pub mod config; // what people write
pub mod model; // config and meshes to objects
pub mod number; // the numbers of a scene, one row for each kind
pub mod read; // files to scenes with the values of their numbers

/// Name and version of the program, in reports and checkpoints.
pub const PROGRAM: &str = concat!("solver ", env!("CARGO_PKG_VERSION"));

pub use model::{ObjectiveBuilder, Scene, ScenePart, Weighted, log_share};
pub use term::material::SceneLaw;
