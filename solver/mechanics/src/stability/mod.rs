//! Paths of equilibria, and where these lose their stability.
//!
//! - [`Continuation`]: paths through limit points, by their arc length;
//! - [`Limit`]: loads at which an equilibrium loses its stability, by a direct method;
//! - [`Burst`]: loads at which the largest stretch is that at break;
//! - [`PressureSlope`]: how much less the pressure rises with the volume than on the way to an equilibrium;
//! - [`Stability`](crate::forward::Stability): how far an equilibrium is from losing it;
//! - [`SoftestMode`]: what a state resists least.

mod bordered;
mod burst;
mod continuation;
mod limit;
mod pressure_slope;
mod softest_mode;
mod spectrum;
mod tangent_system;

pub use burst::{Burst, BurstSearch, FirstBurst};
pub use continuation::{ArcLength, ArcProgress, Continuation};
pub use limit::{Covector, DirectIterate, FirstLimit, Limit, LimitSearch};
pub use pressure_slope::PressureSlope;
pub use softest_mode::SoftestMode;
