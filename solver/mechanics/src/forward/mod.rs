//! From energies to an equilibrium.
//!
//! - [`Problem`]: minimum of the potential energy under [`Dirichlet`] conditions;
//! - [`Newton`]: Newton's method with Hessian modification and a line search;
//! - [`Stepping`]: incremental loading, in load steps of adaptive size;
//! - [`TimeStepper`]: time steps by the backward differentiation formulas (BDF) of an
//!   [`Integrator`], or quasistatic;
//! - [`solve_multipliers`]: pressures, the Lagrange multipliers of prescribed volumes.

mod augmented;
mod ballooning;
mod certificate;
mod dirichlet;
mod evaluated;
mod excursion;
mod failure;
mod hessian_modification;
mod indefinite;
mod integrator;
mod line_search;
mod linearizations;
mod neighbours;
mod newton;
mod path_point;
mod problem;
mod states;
mod stepping;
mod symbolic;
mod tangent;
mod time_stepper;
mod timings;
mod trajectory;
mod volumes;
mod watch;
mod workspace;

pub use certificate::{Uncertified, certificate};
pub use dirichlet::{Dirichlet, Motion};
pub use failure::Failure;
pub use integrator::{Formula, Growth, Integrator, Method, State, Weights};
pub use linearizations::Linearizations;
pub use neighbours::{Varied, neighbours};
pub use newton::{Converged, Newton};
pub use path_point::{ArcPoint, SingularPoint, Singularity, Stability};
pub use problem::{Configuration, Problem};
pub use stepping::{Attempt, GROWTH, LoadStep, Stepping, Unreached, solve, solve_from};
pub(crate) use stepping::{Failed, attempt, certify};
pub use tangent::follow;
pub use time_stepper::{Progress, Reached, TimeStepper};
pub use timings::{Clock, Time, Timings};
pub use trajectory::Trajectory;
pub use volumes::{HeldVolumes, newton_step, solve_multipliers};
pub use watch::{Event, Watch};
pub use workspace::{Linearization, Workspace};
