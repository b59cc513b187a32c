//! The gradient of the load of a limit or of a burst, and of the slope of the pressure.
//!
//! All loads of a state are held, and the pressures p of some chambers are scaled to t p. With t the load of the limit,
//!
//! dt = Σ λ · ∂R + μ · ∂(V − V*)
//!
//! with the covectors of [`Limit::covectors`]. No adjoint system is solved at a limit point. The derivative by p is t
//! times the one by the pressure t p. Where nothing else loads the body, t p does not change with p. The load of a burst
//! changes by what the rest shape does to the stretch, too ([`Burst`]), and the slope by what it does to the volumes
//! ([`PressureSlope`]).

use mesh::Vec3;

use super::{Gradient, along};
use crate::energy::{ChamberId, Iterate, ParameterGradients};
use crate::forward::{Configuration, Failure, Problem, State, Workspace};
use crate::stability::{Burst, Covector, Limit, PressureSlope};

/// A state of which some pressures are scaled by a factor, the load.
#[derive(Clone, Copy)]
pub struct ScaledPressure<'a> {
    /// The problem with its loads over time.
    pub problem: &'a Problem,
    /// The problem with all loads held, except the pressures that are scaled ([`Problem::with_scaled_pressures`]).
    pub held: &'a Problem,
    /// Rest vertices [m].
    pub rest: &'a [Vec3],
    /// Time at which loads are held [s].
    pub time: f64,
    /// The chambers whose pressures are scaled.
    pub chambers: &'a [ChamberId],
}

impl ScaledPressure<'_> {
    /// The derivatives of the load of a limit, as those of a run of one time step.
    pub fn gradient(&self, workspace: &mut Workspace, limit: &Limit) -> Result<Gradient, Failure> {
        let covectors = limit.covectors(self.held, workspace, self.rest)?;
        Ok(self.along_covectors(&covectors, vec![0.0; 3 * self.rest.len()]))
    }

    /// The derivatives of the load of a burst, as those of a run of one time step.
    pub fn gradient_of_burst(&self, burst: &Burst) -> Gradient {
        let covectors = std::slice::from_ref(&burst.covector);
        self.along_covectors(covectors, burst.by_rest.clone())
    }

    /// The derivatives of the slope of the pressure, as those of a run of one time step.
    pub fn gradient_of_slope(
        &self,
        workspace: &mut Workspace,
        state: &Configuration,
        slope: &PressureSlope,
    ) -> Result<Gradient, Failure> {
        let covectors = slope.covectors(self.held, workspace, state)?;
        let by_rest = slope.by_rest(self.held, state, self.chambers);
        let mut gradient = self.along_covectors(&covectors, by_rest);
        for (id, by) in slope.by_pressures(self.held, state, self.chambers) {
            gradient.parameters.add(0, id.owner(), vec![by]);
        }
        Ok(gradient)
    }

    /// The derivatives through the equations, added to those by the rest vertices beside them.
    fn along_covectors(&self, covectors: &[Covector], mut by_rest: Vec<f64>) -> Gradient {
        let mut parameters = ParameterGradients::new(1);
        for covector in covectors {
            let Covector { at, lambda, mu } = covector;
            let state = at.configuration(self.rest, None);
            let (by, _) = along(self.held, &state.iterate(self.held), lambda, mu);
            by_rest.iter_mut().zip(&by).for_each(|(sum, by)| *sum += by);
            let there = Iterate { time: self.time, ..state.iterate(self.problem) };
            let (_, by) = along(self.problem, &there, lambda, mu);
            for (owner, mut by) in by.of_step(0) {
                if self.chambers.iter().any(|id| id.owner() == owner) {
                    by.iter_mut().for_each(|by| *by *= at.time / self.time);
                }
                parameters.add(0, owner, by);
            }
        }
        let zero = vec![0.0; self.problem.dofs()];
        Gradient { rest: by_rest, parameters, start: State::new(zero.clone(), zero) }
    }
}
