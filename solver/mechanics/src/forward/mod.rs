//! From energies to an equilibrium.
//!
//! - [`Problem`]: minimum of the potential energy under [`Dirichlet`] conditions;
//! - [`Newton`]: Newton's method with Hessian modification and a line search;
//! - [`Stepping`]: incremental loading, in load steps of adaptive size;
//! - [`ArcFollower`]: paths of equilibria through limit points, by their arc length;
//! - [`Limit`]: loads at which an equilibrium loses its stability, by a direct method;
//! - [`Burst`]: loads at which the largest stretch is that at break;
//! - [`PressureSlope`]: how much less the pressure rises with the volume than on the way to an equilibrium;
//! - [`Stability`]: how far an equilibrium is from losing it;
//! - [`TimeStepper`]: time steps by the backward differentiation formulas (BDF) of an
//!   [`Integrator`], or quasistatic;
//! - [`solve_multipliers`]: pressures, the Lagrange multipliers of prescribed volumes.

mod assembly;
mod augmented;
mod ballooning;
mod bordered;
mod burst;
mod certificate;
mod cost;
mod dirichlet;
mod hessian_modification;
mod integrator;
mod limit;
mod line_search;
mod linearizations;
mod neighbours;
mod newton;
mod path;
mod pressure_slope;
mod problem;
mod softest_mode;
mod stability;
mod states;
mod stepping;
mod symbolic;
mod tangent;
mod tangent_system;
mod time_stepper;
mod timings;
mod trajectory;
mod volumes;
mod watch;
mod workspace;

pub use burst::{Burst, BurstSearch, Torn};
pub use certificate::{Uncertified, certificate};
pub use cost::{Steps, about, predicted_iterations, predicted_time};
pub use dirichlet::{Dirichlet, Motion};
pub use integrator::{Formula, Growth, Integrator, Method, State, Weights};
pub use limit::{Covector, First, Left, Limit, LimitSearch};
pub use linearizations::Linearizations;
pub use neighbours::{Varied, neighbours};
pub use newton::{Converged, Failure, Newton};
pub use path::{ArcFollower, ArcLength, ArcProgress};
pub use pressure_slope::PressureSlope;
pub use problem::{Configuration, Problem};
pub use softest_mode::SoftestMode;
pub use stability::{Kind, Stability};
pub use stepping::{
    ArcPoint, Attempt, LoadStep, Passed, Solution, Stepping, Unreached, solve, solve_from,
    solve_in_time,
};
pub use tangent::follow;
pub use time_stepper::{Progress, Reached, TimeStepper};
pub use timings::{Clock, Time, Timings};
pub use trajectory::Trajectory;
pub use volumes::{newton_step, solve_multipliers};
pub use watch::{Event, Watch};
pub use workspace::{Linearization, Workspace};
