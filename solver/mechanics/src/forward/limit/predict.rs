//! The limit of a body whose rest shape moves, to first order.

use mesh::Vec3;

use super::{Limit, Sought, factor_pinned, first_mode, largest_entry};
use crate::forward::stability::Kind;
use crate::forward::tangent_system::Residual;
use crate::forward::{Configuration, Failure, Problem, Workspace};

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
        let change = Residual::change(problem, workspace, &at, motion);
        Sought { mode: &mode, kind, pin: &pin }.step(problem, workspace, limit, &change, None)
    }
}
