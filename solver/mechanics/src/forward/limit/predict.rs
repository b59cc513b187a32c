//! The limit of a body whose rest shape moves, to first order.

use mesh::Vec3;

use super::{Limit, Sought, factor_pinned, first_mode, largest_entry};
use crate::energy::Iterate;
use crate::forward::stability::Kind;
use crate::forward::tangent_system::Residual;
use crate::forward::{Configuration, Failure, Problem, Workspace};

/// Half of the difference, as a fraction of the motion.
const STEP: f64 = 1e-5;

impl Limit {
    /// A state near the limit of a moved rest shape, from that at the limit: J δ + ∂R/∂X dX = 0 of forces, volumes and
    /// load with the softest mode held, at a bifurcation the load as well.
    ///
    /// # Errors
    /// [`Failure`] where the tangent is singular beside that.
    pub fn predicted<'a>(
        problem: &Problem,
        workspace: &mut Workspace,
        limit: &Configuration<'a>,
        kind: Kind,
        motion: &[Vec3],
    ) -> Result<Configuration<'a>, Failure> {
        let at = limit.iterate(problem);
        let mode = first_mode(problem, workspace, &at)?;
        let pin = factor_pinned(problem, workspace, &at, largest_entry(&mode)?)?;
        let mut moved = |by: f64| {
            let rest: Vec<Vec3> = at.rest.iter().zip(motion).map(|(x, d)| x + by * d).collect();
            Residual::of(problem, workspace, &Iterate { rest: &rest, ..at })
        };
        let (mut change, after) = (moved(-STEP), moved(STEP));
        let slope = |before: f64, after: f64| (after - before) / (2.0 * STEP);
        change.force.iter_mut().zip(&after.force).for_each(|(r, after)| *r = slope(*r, *after));
        let gaps: Vec<f64> =
            change.gaps().iter().zip(after.gaps()).map(|(r, after)| slope(*r, after)).collect();
        for (constraint, gap) in change.constraints.iter_mut().zip(gaps) {
            constraint.volume = constraint.wanted + gap;
        }
        Sought { mode: &mode, kind, pin: &pin }.step(problem, workspace, limit, &change, None)
    }
}
