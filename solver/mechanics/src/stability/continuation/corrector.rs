//! Newton's method from a predicted state to the path.

use super::ArcStep;
use crate::energy::Iterate;
use crate::forward::{Configuration, Converged, Event, Failure, Newton, Workspace};
use crate::stability::tangent_system::{Residual, Row, Step};

/// Newton iterations of a corrector, at most: a shorter arc is better than more of them.
const ITERATIONS: usize = 12;
/// Relative error of Δs² that counts as none: nothing but the place of a state depends on it.
const ON_SPHERE: f64 = 1e-6;
/// Iterations after which a residual that has not halved may be within rounding.
const STALLED: usize = 3;
/// Iterations after which one that is what it was two iterations before goes to and fro, ...
const CYCLES: usize = 5;
/// ... up to this, relative to it.
const SAME: f64 = 0.01;

/// Where the next state lies.
#[derive(Clone, Copy)]
pub enum Ends {
    /// At this arc length from the last one.
    OnSphere(f64),
    /// At the full load.
    AtFullLoad,
}

/// Newton's method on the equations of a path.
pub struct Corrector<'a> {
    pub from: &'a ArcStep<'a>,
    pub newton: &'a Newton,
    pub ends: Ends,
}

impl Corrector<'_> {
    /// Moves a state to the path, and adds the residual of every iterate [N] to `residuals`. None where the path goes
    /// beyond the full load, where loads are not defined.
    pub fn correct(
        &self,
        workspace: &mut Workspace,
        state: &mut Configuration,
        residuals: &mut Vec<f64>,
    ) -> Result<Option<Converged>, Failure> {
        let problem = self.from.problem;
        let (mut peak, mut before) = (0.0_f64, [f64::INFINITY; 2]);
        for iterations in 0..=ITERATIONS {
            let now = Residual::of(problem, workspace, &state.iterate(problem));
            peak = peak.max(now.scale);
            let (residual, wanted) = (now.norm(), self.newton.wanted(now.scale, peak));
            residuals.push(residual);
            log::debug!("path {iterations}  |g| {residual:.2e} N");
            let (time, iteration) = (self.from.last.time, iterations);
            let event = Event::Iterate { time, iteration, residual, wanted };
            if workspace.notify(&event).is_break() {
                return Err(Failure::Interrupted);
            }
            let (side, _) = self.place(&state.iterate(problem));
            let placed = side.abs() <= ON_SPHERE * self.square();
            if placed && now.largest_gap() <= self.newton.relative {
                if residual <= wanted {
                    let floor = None;
                    return Ok(Some(Converged { iterations, residual, wanted, floor, peak }));
                }
                let stalled = iterations >= STALLED && residual > 0.5 * before[1];
                let floor =
                    stalled.then(|| workspace.rounding_floor(problem, &state.iterate(problem)));
                if floor.is_some_and(|floor| residual <= floor) {
                    return Ok(Some(Converged { iterations, residual, wanted, floor, peak }));
                }
            }
            if !residual.is_finite() {
                return Err(Failure::Inadmissible);
            }
            // forces of contact have kinks, at which Newton's method may go to and fro
            let cycles = iterations >= CYCLES && (residual / before[0] - 1.0).abs() < SAME;
            if iterations == ITERATIONS || cycles {
                return Err(Failure::IterationLimit { iterations, residual, wanted });
            }
            if !self.step(workspace, state, &now)? {
                return Ok(None);
            }
            before = [before[1], residual];
        }
        unreachable!("the last iteration returns")
    }

    /// How far a state is from its place, and the derivative of that.
    fn place(&self, at: &Iterate) -> (f64, Row) {
        let (change, scale) = (self.from.change(at), self.from.progress.scale);
        match self.ends {
            Ends::OnSphere(length) => {
                let off = 0.5 * (change.product(&change, scale) - length * length);
                (off, change.row(scale))
            }
            Ends::AtFullLoad => {
                let u = vec![0.0; change.u.len()];
                (at.time - self.from.end, Row { u, load: 1.0 })
            }
        }
    }

    /// What an error of the place is compared with.
    fn square(&self) -> f64 {
        match self.ends {
            Ends::OnSphere(length) => length * length,
            Ends::AtFullLoad => 1.0,
        }
    }

    /// One step with the exact tangent, cut where surfaces meet or the energy is not finite; false where the path goes
    /// beyond the full load.
    fn step(
        &self,
        workspace: &mut Workspace,
        state: &mut Configuration,
        now: &Residual,
    ) -> Result<bool, Failure> {
        let problem = self.from.problem;
        let at = state.iterate(problem);
        let (off, row) = self.place(&at);
        let step = Step::newton(problem, workspace, &at, now, row, off)?;
        let whole = step.from(problem, state, 1.0);
        if whole.time > self.from.end && matches!(self.ends, Ends::OnSphere(_)) {
            return Ok(false);
        }
        *state = step.cut(problem, workspace, state);
        Ok(true)
    }
}
