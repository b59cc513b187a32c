//! The outer loop: from an objective's gradient to a better shape.

mod cascade;
mod checkpoint;
mod lbfgs;
mod lbfgsb;
mod level;
pub mod validity;

pub use cascade::{Cascade, Finished};
pub use checkpoint::Checkpoint;
pub use lbfgs::Lbfgs;
pub use lbfgsb::projected_gradient_norm;
pub use level::{Evaluation, Level, Rejected};
