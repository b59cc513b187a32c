//! The outer loop: from an objective's gradient to a better shape.

mod cascade;
mod checkpoint;
mod history;
mod lbfgs;
mod lbfgsb;
mod level;
mod parameter;
mod rest_path;
mod trial_step;
pub mod validity;

pub use cascade::{Cascade, Finished, mesh_file};
pub use checkpoint::Checkpoint;
pub use lbfgs::Lbfgs;
pub use lbfgsb::projected_gradient_norm;
pub use level::{Evaluation, Level, Rejected, Start};
pub use parameter::{Parameter, Perturbed};
