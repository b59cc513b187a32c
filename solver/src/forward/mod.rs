//! From energies to an equilibrium.

mod augmented;
mod certificate;
mod integrator;
mod ladder;
mod line_search;
mod march;
mod newton;
mod softness;
mod states;
mod stepping;
mod system;
mod tangent;
mod trajectory;
mod volumes;

pub use certificate::{Uncertified, certificate};
pub use integrator::{Integrator, Method, State};
pub use march::{March, Progress, Reached};
pub use newton::{Converged, Failure, Newton};
pub use softness::Softness;
pub use stepping::{
    Attempt, LoadStep, Solution, Stepping, Unreached, solve, solve_from, solve_in_time,
};
pub use system::{System, Timings};
pub use tangent::follow;
pub use trajectory::Trajectory;
