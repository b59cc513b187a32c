//! From energies to an equilibrium.

mod certificate;
mod newton;
mod stepping;
mod system;
mod tangent;
mod volumes;

pub use certificate::{Uncertified, certificate};
pub use newton::{Failure, Newton};
pub use stepping::{LoadStep, Solution, Stepping, Unreached, solve, solve_from, solve_in_time};
pub use system::{System, Timings};
pub use tangent::follow;
