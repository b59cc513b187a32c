//! How much less the pressure rises with the volume at an equilibrium than on average from rest to there,
//!
//! s = (dP/dV) / (P/ΔV),   ΔV = V − V₀
//!
//! 1 where the body answers in proportion, more where it stiffens, and 0 at a limit point, where the pressure has its
//! maximum. It costs one solve and no path. With several pressures P_i that grow in proportion, as α P_i, their work stands
//! for the volume:
//!
//! s = W/D,   W = Σ P_i ΔV_i,   D = dW/dα = F · x,   J x = F = −∂R/∂α
//!
//! with the tangent J of forces R and prescribed volumes. The path x = dz/dα and its second derivative
//! w = d²z/dα² are those of the minimum of the energy Π(z, α), of which W and D are the first two derivatives, negative. So
//! anything that changes R changes them by
//!
//! dW = −x · ∂R + ∂W,   dD = −(w · ∂R + d/dε x · ∂R(z + ε x) + 2 x · ∂(∂R/∂α)),
//! J w = −(∂J/∂z · x) x − 2 ∂J/∂α x
//!
//! As R is linear in α, its derivative is twice the difference to half of the pressures.
//!
//! A bifurcation of a symmetrical body is not seen, as the load has no share in its mode.
//!
//! Source: derivatives of an optimal value, as in Fiacco 1983, "Introduction to Sensitivity and Stability Analysis in
//! Nonlinear Programming", chapter 3.

use super::limit::Covector;
use super::spectrum::negative_eigenvalues;
use super::tangent_system::{Direction, Residual, at_held_load, by_multiplier, factor};
use crate::energy::ChamberId;
use crate::forward::{Configuration, Failure, Problem, Reached, Workspace};
use crate::math::linear::dot;

/// Motion of the difference along the path beside that of differences of tangents.
const SHORTER: f64 = 0.1;

/// The slope of the pressure at an equilibrium.
pub struct PressureSlope {
    /// s [1].
    pub value: f64,
    /// Negative eigenvalues of the tangent: none where the body is stable.
    pub negative: usize,
    /// x.
    path: Direction,
    /// D [J].
    compliance: f64,
}

impl PressureSlope {
    /// The slope by the pressures of some chambers, which grow in proportion to the load ([`Problem::held`]).
    pub fn of(
        held: &Problem,
        workspace: &mut Workspace,
        state: &Configuration,
        growing: &[ChamberId],
    ) -> Result<Self, Failure> {
        let (at, half) = (state.iterate(held), with_half(state));
        let now = Residual::of(held, workspace, &at);
        let less = Residual::of(held, workspace, &half.iterate(held));
        let force = less.force.iter().zip(&now.force).map(|(less, now)| 2.0 * (less - now));
        let force: Vec<f64> = force.collect();
        let factor = factor(held, workspace, &at).ok_or(Failure::Inadmissible)?;
        let tangent = at_held_load(held, factor, &now.constraints);
        let negative = negative_eigenvalues(factor, &tangent);
        let volumes = vec![0.0; now.constraints.len()];
        let (v, pressures) = tangent.solve(factor, &force, &volumes).ok_or(Failure::Singular)?;
        let compliance = dot(&force, &v);
        if compliance == 0.0 {
            return Err(Failure::NoLoad);
        }
        let value = work(held, state, growing) / compliance;
        if !value.is_finite() {
            return Err(Failure::Singular);
        }
        Ok(Self { value, negative, path: Direction { v, pressures }, compliance })
    }

    /// What makes changes of the equations one of the slope. The tangent is factored once more.
    pub fn covectors(
        &self,
        held: &Problem,
        workspace: &mut Workspace,
        state: &Configuration,
    ) -> Result<Vec<Covector>, Failure> {
        let Self { value, path, compliance, .. } = self;
        let second = self.second_derivative(held, workspace, state)?;
        let constraints = held.constraints(&state.iterate(held));
        let covector = |state: &Configuration, direction: &Direction, by: f64| {
            let v: Vec<f64> = direction.v.iter().map(|v| by * v).collect();
            let pressures: Vec<f64> = direction.pressures.iter().map(|p| -by * p).collect();
            let mu = by_multiplier(state.multipliers.len(), &constraints, &pressures);
            Covector { at: Reached::of(&state.iterate(held)), lambda: held.prolong(&v), mu }
        };
        let of_slope = value / compliance;
        let step = SHORTER * path.step(&state.iterate(held));
        let along = |by: f64| {
            covector(&path.moved(held, state, by * step), path, 0.5 * by * of_slope / step)
        };
        Ok(vec![
            covector(state, path, 4.0 * of_slope - 1.0 / compliance),
            covector(&with_half(state), path, -4.0 * of_slope),
            covector(state, &second, of_slope),
            along(1.0),
            along(-1.0),
        ])
    }

    /// w.
    fn second_derivative(
        &self,
        held: &Problem,
        workspace: &mut Workspace,
        state: &Configuration,
    ) -> Result<Direction, Failure> {
        let (at, half) = (state.iterate(held), with_half(state));
        let curvature = self.path.curvature(held, workspace, state);
        let full = self.path.times_tangent(held, workspace, &at);
        let less = self.path.times_tangent(held, workspace, &half.iterate(held));
        let side = |curvature: &[f64], full: &[f64], less: &[f64]| -> Vec<f64> {
            let rate = full.iter().zip(less).map(|(full, less)| 2.0 * (full - less));
            curvature.iter().zip(rate).map(|(curvature, rate)| -curvature - 2.0 * rate).collect()
        };
        let upper = side(&curvature.0, &full.0, &less.0);
        let lower = side(&curvature.1, &full.1, &less.1);
        let constraints = held.constraints(&at);
        let factor = factor(held, workspace, &at).ok_or(Failure::Inadmissible)?;
        let tangent = at_held_load(held, factor, &constraints);
        let (v, pressures) = tangent.solve(factor, &upper, &lower).ok_or(Failure::Singular)?;
        Ok(Direction { v, pressures })
    }

    /// What the rest vertices change of the slope beside the equations [1/m], three components per vertex.
    pub fn by_rest(
        &self,
        held: &Problem,
        state: &Configuration,
        growing: &[ChamberId],
    ) -> Vec<f64> {
        let mut by_rest = vec![0.0; 3 * state.rest.len()];
        let at = state.iterate(held);
        for id in growing {
            let chamber = held.energies.chamber(*id);
            let by_volume = chamber.state(&at).1.pressure / self.compliance;
            chamber.add_growth_by_rest(&at, by_volume, &mut by_rest);
        }
        by_rest
    }

    /// What the pressures that grow change of the slope beside the equations [1/Pa], at the load at which they are held.
    pub fn by_pressures(
        &self,
        held: &Problem,
        state: &Configuration,
        growing: &[ChamberId],
    ) -> Vec<(ChamberId, f64)> {
        let at = state.iterate(held);
        let change = |id: &ChamberId| {
            let chamber = held.energies.chamber(*id);
            (*id, (chamber.state(&at).0 - chamber.rest_volume(&at)) / self.compliance)
        };
        growing.iter().map(change).collect()
    }
}

/// W [J].
fn work(held: &Problem, state: &Configuration, growing: &[ChamberId]) -> f64 {
    let at = state.iterate(held);
    let of = |id: &ChamberId| {
        let chamber = held.energies.chamber(*id);
        let (volume, gas) = chamber.state(&at);
        gas.pressure * (volume - chamber.rest_volume(&at))
    };
    growing.iter().map(of).sum()
}

/// A state with half of the pressures that grow. Without any, the other loads would not be held.
fn with_half<'a>(state: &Configuration<'a>) -> Configuration<'a> {
    Configuration { time: 0.5 * state.time, ..state.clone() }
}

#[cfg(test)]
mod tests;
