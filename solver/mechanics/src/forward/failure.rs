//! Why there is no equilibrium.

use super::Uncertified;

/// Why there is no equilibrium. Not a panic: the caller decides.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The start is not admissible.
    #[error("the starting shape has inverted elements, or an energy or forces that are not finite")]
    Inadmissible,
    /// Too many iterations.
    #[error(
        "{iterations} Newton iterations were not enough: residual {residual:.2e} N, wanted {wanted:.2e} N"
    )]
    IterationLimit {
        /// Iterations made.
        iterations: usize,
        /// Residual reached [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
    },
    /// A chamber balloons, and its walls bear less the more it grows.
    #[error(
        "a chamber balloons: its walls bear less the more it grows, from {start:.3e} to {volume:.3e} m³ in \
         {iterations} Newton iterations"
    )]
    Balloons {
        /// Iterations made.
        iterations: usize,
        /// Volume at the start [m³].
        start: f64,
        /// Volume after them [m³].
        volume: f64,
    },
    /// No step decreases the energy.
    #[error(
        "no Newton step decreases the energy after {iterations} iterations: residual {residual:.2e} N, wanted {wanted:.2e} N"
    )]
    Stalled {
        /// Iterations made.
        iterations: usize,
        /// Residual reached [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
    },
    /// The forces balance, but a chamber does not take its prescribed volume.
    #[error(
        "the forces balance, but a chamber with the prescribed volume {wanted:.6e} m³ has \
         {volume:.6e} m³"
    )]
    Volume {
        /// Volume reached [m³].
        volume: f64,
        /// Volume prescribed [m³].
        wanted: f64,
    },
    /// Steps are within rounding, but the residual is not.
    #[error(
        "Newton's method stagnated after {iterations} iterations: residual {residual:.2e} N, \
         wanted {wanted:.2e} N, floor by rounding about {floor:.1e} N"
    )]
    Stagnated {
        /// Iterations made.
        iterations: usize,
        /// Smallest residual reached [N].
        residual: f64,
        /// Residual wanted [N].
        wanted: f64,
        /// Estimated floor by rounding [N].
        floor: f64,
        /// The forces that have to balance [N].
        scale: f64,
    },
    /// The forces balance, but an element is turned inside out, or might be.
    #[error("the forces balance, but {0}")]
    Uncertified(#[from] Uncertified),
    /// The forces balance, but an energy objects to the state.
    #[error("the forces balance, but {0}")]
    Objection(String),
    /// Supports or obstacles would push surfaces through each other.
    #[error(
        "supports or obstacles meet a surface after {:.1} % of their motion in this step",
        100.0 * free
    )]
    Blocked {
        /// Fraction of the motion that is free.
        free: f64,
    },
    /// The tangent is singular: a body that may move freely, or a state at which several branches meet.
    #[error("the tangent stiffness is singular")]
    Singular,
    /// Nothing depends on the load.
    #[error("no load: nothing changes between t = 0 and t = 1")]
    NoLoad,
    /// The next state is none of the same branch.
    #[error("the path would turn by {degrees:.0}° from one state to the next")]
    Strayed {
        /// Angle between the directions of the path [°].
        degrees: f64,
    },
    /// Facets meet between which nothing acts.
    #[error(
        "facets of the surface meet on the way to the next state, and no contact keeps them apart: those of one \
         edge or wall, which solid lies between; the mesh is too coarse there"
    )]
    Folded,
    /// Who watches has broken off.
    #[error("interrupted")]
    Interrupted,
}
