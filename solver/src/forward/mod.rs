//! From energies to an equilibrium.

mod certificate;
mod newton;
mod stepping;
mod system;
mod tangent;

pub use certificate::{Uncertified, certificate};
pub use newton::{Failure, Newton};
pub use stepping::{LoadStep, Solution, Stepping, Unreached, solve, solve_from};
pub use system::{System, Timings};
pub use tangent::follow;
