//! Foresees where the exact Hessian is not positive definite, so that no time is lost with making and factoring it.

use super::Workspace;
use super::hessian_modification::Modification;
use crate::math::linear::Factorization;

/// Ratio of residuals that tells one stage of the iteration from another.
const STAGE_RATIO: f64 = 10.0;
/// Steps with a modified Hessian before the exact one is tried again: at first, and at most where it is found to be
/// indefinite time and again.
const MODIFIED_STEPS: (usize, usize) = (2, 8);

/// What is known of the exact Hessian.
///
/// After a step with a modified Hessian, the next one is of the same kind until the residual has fallen a lot, or for
/// [`MODIFIED_STEPS`] steps.
pub(super) struct Indefinite {
    /// Whether the first Hessian is taken to be indefinite.
    is_expected: bool,
    /// Whether no exact Hessian was tried since that of the load before.
    follows_tangent: bool,
    /// Residual where the Hessian was last found to be indefinite [N].
    found: f64,
    /// Steps since, and most of them.
    steps: [usize; 2],
}

impl Indefinite {
    /// At the start, where the Hessian may be expected to be indefinite, or is to be that of the load before.
    pub fn new(is_expected: bool, follows_tangent: bool) -> Self {
        let steps = [0, MODIFIED_STEPS.0];
        Self { is_expected, follows_tangent, found: f64::INFINITY, steps }
    }

    /// The modification to begin with.
    pub fn modification(&mut self, residual: f64) -> Modification {
        let [steps, most] = self.steps;
        let lasts = steps < most && residual * STAGE_RATIO > self.found;
        if lasts || std::mem::take(&mut self.is_expected) {
            return Modification::Projected;
        }
        Modification::Near
    }

    /// Whether the exact Hessian is not to be factored before conjugate gradients have found it positive definite.
    pub fn is_doubtful(&self, workspace: &Workspace) -> bool {
        let has_factor = workspace.linear().last().is_some_and(Factorization::is_positive);
        !has_factor || self.follows_tangent
    }

    /// Takes note of the modification that a step began with, and of the one it took.
    pub fn watch(&mut self, residual: f64, from: Modification, by: Modification) {
        self.follows_tangent &= from == Modification::Projected;
        if by < Modification::Projected {
            self.found = f64::INFINITY;
        } else if from < Modification::Projected {
            let [steps, most] = &mut self.steps;
            if self.found.is_finite() {
                *most = (2 * *most).min(MODIFIED_STEPS.1);
            }
            (self.found, *steps) = (residual, 0);
        } else {
            self.steps[0] += 1;
        }
    }
}
