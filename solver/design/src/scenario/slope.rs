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
use run::limit::growing;

/// The end of a run, with pressures that may be scaled.
struct Scaled<'a> {
    problem: Problem,
    chambers: Vec<ChamberId>,
    end: Configuration<'a>,
    slope: PressureSlope,
}

impl Scenario {
    /// Whether the slope is kept.
    pub(super) fn keeps_slope(&self) -> bool {
        self.bounds.iter().any(Bound::is_slope)
    }

    /// The slope at the end of some states; none where it is not kept.
    pub(super) fn slope(
        &self,
        problem: &Problem,
        rest: &[Vec3],
        states: &Trajectory,
    ) -> Result<Option<f64>, Rejected> {
        if !self.keeps_slope() {
            return Ok(None);
        }
        let slope = self.scaled_pressure(problem, rest, states)?.slope;
        if slope.negative > 0 {
            return Err(self.reject("its equilibrium is not stable"));
        }
        Ok(Some(slope.value))
    }

    fn scaled_pressure<'a>(
        &self,
        problem: &Problem,
        rest: &'a [Vec3],
        states: &Trajectory,
    ) -> Result<Scaled<'a>, Rejected> {
        let mut workspaces = self.workspaces();
        let (u, time) = (states.last(), self.times[states.steps() - 1]);
        let at = problem.iterate(rest, &u, time);
        let multipliers = solve_multipliers(problem, &mut workspaces.equilibrium, &at);
        let end = Configuration {
            rest,
            time,
            step: None,
            u: u.into_owned(),
            multipliers,
            balanced_at: None,
        };
        let chambers = growing(problem, &self.scene.config.limit.clone().unwrap_or_default());
        let problem = problem.with_scaled_pressures(time, &chambers);
        // the unknowns are those of the shape before
        let workspace = workspaces.slope.get_or_insert_with(|| Workspace::new(&problem));
        let slope = PressureSlope::of(&problem, workspace, &end, &chambers);
        let slope =
            slope.map_err(|why| self.reject(format!("the pressure has no slope: {why}")))?;
        Ok(Scaled { problem, chambers, end, slope })
    }

    /// Adds the derivatives of the slope at the end of a run, times a factor.
    pub(super) fn add_slope(
        &self,
        run: &Run,
        factor: f64,
        gradient: &mut Gradient,
    ) -> Result<(), Rejected> {
        let Run { problem, rest, states, .. } = run;
        let scaled = self.scaled_pressure(problem, rest, states)?;
        let Scaled { problem: held, chambers, end, slope } = &scaled;
        let scaled = ScaledPressure { problem, held, rest, time: end.time, chambers };
        let mut workspaces = self.workspaces();
        let workspace = workspaces.slope.as_mut().expect("that of the slope");
        let by = scaled.gradient_of_slope(workspace, end, slope).map_err(|why| {
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
