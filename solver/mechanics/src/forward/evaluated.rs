//! An iterate of Newton's method with what was computed there.

use super::line_search::Accepted;
use super::{Problem, Workspace};
use crate::energy::Iterate;
use crate::math::linear::norm;

/// A displacement and the forces there.
#[derive(Clone)]
pub(super) struct Evaluated {
    /// u [m].
    pub u: Vec<f64>,
    /// The energy [J].
    pub energy: f64,
    /// The gradient over all degrees of freedom [N].
    pub gradient: Vec<f64>,
    /// Scale of the forces [N].
    pub scale: f64,
    /// Norm of the free part of the gradient [N].
    pub residual: f64,
}

impl Evaluated {
    /// A step's end, in all else as `at`.
    pub fn of(
        accepted: Accepted,
        problem: &Problem,
        workspace: &mut Workspace,
        at: &Iterate,
    ) -> Self {
        let Accepted { u, energy, gradient, .. } = accepted;
        let (gradient, scale) =
            gradient.unwrap_or_else(|| workspace.gradient(problem, &Iterate { u: &u, ..*at }));
        let residual = norm(&problem.restrict(&gradient));
        Self { u, energy, gradient, scale, residual }
    }
}
