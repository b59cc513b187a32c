//! The outer loop: shape optimisation in a cascade of levels by sequential quadratic programming within a trust region,
//! with the model of Gauss and Newton or one from gradients (L-BFGS).

mod bounds;
mod cascade;
mod checkpoint;
mod curvature;
mod ending;
pub mod folder;
mod history;
mod kept;
mod level;
mod meshes;
mod molding;
mod parameter;
mod problem;
mod rest_path;
mod robust;
mod scenario;
mod shares;
mod validity;

pub use scenario::scene_of;

pub use cascade::Cascade;
pub use history::History;
pub use level::{Evaluation, Level};
pub use parameter::{Derivative, Parameter, Perturbed};
pub use problem::Problem;

use checkpoint::Checkpoint;
use meshes::Meshes;
use scenario::{Rejected, Run, Scenario};
