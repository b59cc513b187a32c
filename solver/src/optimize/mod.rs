//! The outer loop: from an objective's gradient to a better shape.

mod cascade;
mod checkpoint;
mod design_map;
mod lbfgs;
mod level;
pub mod validity;

pub use cascade::{Cascade, Finished};
pub use checkpoint::Checkpoint;
pub use design_map::DesignMap;
pub use lbfgs::Lbfgs;
pub use level::{Evaluation, Level, Rejected};
