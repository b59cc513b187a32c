//! The slope of the pressure at the end of a run, where a design keeps it.
//!
//! s = dP/dV · ΔV/P      1 where the body answers in proportion, 0 where it balloons
//!
//! It costs one solve with the tangent, and one for its gradient ([`PressureSlope`]).

use mechanics::adjoint::{Gradient, ScaledPressure};
use mechanics::energy::ChamberId;
use mechanics::forward::{Configuration, Problem, Trajectory, Workspace, solve_multipliers};
use mechanics::stability::PressureSlope;
use mesh::Vec3;

use super::{Bound, Rejected, Run, Scenario};
use crate::run::limit::growing;

/// The equilibrium whose pressures grow.
struct Growing<'a> {
    held: Problem,
    chambers: Vec<ChamberId>,
    end: Configuration<'a>,
}

impl Scenario {
    /// Whether the slope is kept.
    fn keeps_slope(&self) -> bool {
        self.bounds.iter().any(Bound::is_slope)
    }

    /// The slope at the end of some states; none where it is not kept.
    pub(super) fn slope(
        &mut self,
        problem: &Problem,
        rest: &[Vec3],
        states: &Trajectory,
    ) -> Result<Option<f64>, Rejected> {
        if !self.keeps_slope() {
            return Ok(None);
        }
        let (growing, slope) = self.slope_at(problem, rest, states)?;
        self.growing = Some(growing.1);
        if slope.negative > 0 {
            return Err(self.reject("its equilibrium is not stable"));
        }
        Ok(Some(slope.value))
    }

    /// What grows at the end of some states, with the slope and what it was solved with.
    fn slope_at<'a>(
        &mut self,
        problem: &Problem,
        rest: &'a [Vec3],
        states: &Trajectory,
    ) -> Result<((Growing<'a>, Workspace), PressureSlope), Rejected> {
        let (u, time) = (states.last(), self.times[states.steps() - 1]);
        let at = problem.iterate(rest, &u, time);
        let multipliers = solve_multipliers(problem, &mut self.workspace, &at);
        let u = u.clone().into_owned();
        let end = Configuration { rest, time, step: None, u, multipliers };
        let chambers = growing(problem, &self.scene.config.limit.clone().unwrap_or_default());
        let held = problem.with_scaled_pressures(time, &chambers);
        // the unknowns are those of the shape before
        let mut workspace = self.growing.take().unwrap_or_else(|| Workspace::new(&held));
        let slope = PressureSlope::of(&held, &mut workspace, &end, &chambers);
        let slope =
            slope.map_err(|why| self.reject(format!("the pressure has no slope: {why}")))?;
        Ok(((Growing { held, chambers, end }, workspace), slope))
    }

    /// Adds the derivatives of the slope at the end of a run, times a factor.
    pub(super) fn add_slope(
        &mut self,
        run: &Run,
        factor: f64,
        gradient: &mut Gradient,
    ) -> Result<(), Rejected> {
        let Run { problem, rest, states, .. } = run;
        let ((growing, mut workspace), slope) = self.slope_at(problem, rest, states)?;
        let Growing { held, chambers, end } = &growing;
        let scaled = ScaledPressure { problem, held, rest, time: end.time, chambers };
        let by = scaled.gradient_of_slope(&mut workspace, end, &slope);
        self.growing = Some(workspace);
        let by = by.map_err(|why| {
            self.reject(format!("the slope of the pressure has no gradient: {why}"))
        })?;
        gradient.rest.iter_mut().zip(&by.rest).for_each(|(sum, by)| *sum += factor * by);
        for (id, by) in by.parameters.of_step(0) {
            let by = by.iter().map(|by| factor * by).collect();
            gradient.parameters.add(run.states.steps() - 1, id, by);
        }
        Ok(())
    }
}
