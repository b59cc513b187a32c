//! The outer loop: shape optimisation in a cascade of levels by sequential quadratic programming within a trust region,
//! with the model of Gauss and Newton or one from gradients (L-BFGS).

mod bounds;
mod cascade;
mod checkpoint;
mod costs;
mod curvature;
mod ending;
mod history;
mod kept;
mod lbfgs;
mod level;
mod mesh_files;
mod meshes;
mod molding;
mod offset;
mod parameter;
mod quadratic;
mod remesh;
mod rest_path;
mod robust;
mod scenario;
mod shares;
mod trust_region;
mod validity;
mod vectors;

pub use scenario::scene_of;

pub use cascade::{CASTABLE, Cascade, Finished, LATEST};
pub use checkpoint::Checkpoint;
pub use history::History;
pub use level::{Evaluation, Level, Start};
pub use mesh_files::{mesh_file, write_bodies};
pub use meshes::Meshes;
pub use molding::Molding;
pub use parameter::{Derivative, Parameter, Perturbed};
pub use scenario::{Rejected, Run, Scenario};
