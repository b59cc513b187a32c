//! The outer loop: shape optimisation in a cascade of levels, by a quasi-Newton method (L-BFGS, within bounds
//! L-BFGS-B) with a backtracking line search, or by the Gauss–Newton method within a trust region.

mod cascade;
mod checkpoint;
mod curvature;
mod history;
mod lbfgs;
mod lbfgsb;
mod level;
mod meshes;
mod molding;
mod offset;
mod parameter;
mod progress;
mod remesh;
mod rest_path;
mod robust;
mod scenario;
mod shares;
mod trial_step;
mod trust_region;
pub mod validity;

pub use cascade::{Cascade, Finished, LATEST};
pub use checkpoint::Checkpoint;
pub use history::History;
pub use lbfgs::Lbfgs;
pub use lbfgsb::projected_gradient_norm;
pub use level::{Evaluation, Level, Start};
pub use meshes::Meshes;
pub use molding::Molding;
pub use parameter::{Derivative, Parameter, Perturbed};
pub use remesh::{mesh_file, write_bodies};
pub use scenario::{Rejected, Run, Scenario, scene_of};
