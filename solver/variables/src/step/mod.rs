//! Steps in the variables: quadratic models of the objective, how far these are trusted, and the way back to what is kept.

mod lbfgs;
mod least_motion;
mod quadratic;
mod trust_region;

pub use lbfgs::Lbfgs;
pub use least_motion::LeastMotion;
pub use quadratic::{Minimum, Model, Problem, Row};
pub use trust_region::{TrustRegion, step_within};
