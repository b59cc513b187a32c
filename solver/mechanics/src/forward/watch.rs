//! What can be watched while equilibria are sought.

use std::ops::ControlFlow;

/// Something that happened on the way to an equilibrium.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// An iterate of Newton's method.
    Iterate {
        /// Time that it goes towards [s].
        time: f64,
        /// Iterations made so far.
        iteration: usize,
        /// Norm of the unbalanced force [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
    },
    /// The adjoint comes to a time step, on its way from the last to the first.
    Adjoint {
        /// Number of the time step, counted from 1.
        step: usize,
    },
    /// An equilibrium was accepted with a residual above the wanted one, as rounding allows no less.
    AtRoundingFloor {
        /// Time of the equilibrium [s].
        time: f64,
        /// Norm of the unbalanced force [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
        /// Estimated floor [N].
        floor: f64,
    },
    /// States beyond the budget are in memory all the same.
    KeptInMemory {
        /// Why they could not be written to disk.
        error: &'a std::io::Error,
    },
}

/// Gets to know of every [`Event`]. Where it breaks off at an iterate, Newton's method ends as
/// [`Failure::Interrupted`](super::Failure::Interrupted), and where it does at a time step, the adjoint as
/// [`NoGradient::Interrupted`](crate::adjoint::NoGradient::Interrupted).
pub type Watch = Box<dyn FnMut(&Event) -> ControlFlow<()> + Send + Sync>;
