//! What changes of the equations do to the load of a limit.
//!
//! With J φ = 0 of the symmetric tangent J of forces R and volumes, φ · (R, V − V*) = 0 holds to first order in all
//! directions but that of the load. At a limit point this gives
//!
//! dt = −φ · ∂(R, V − V*) / c,   c = φ · ∂(R, V − V*)/∂t
//!
//! At a bifurcation c vanishes, and t is where h = φ · J φ vanishes along the path of the body without its branch,
//! with the share of φ in the change of the state held, A = [J φ; φᵀ 0]:
//!
//! dt = −(∂h − a · ∂(R, V − V*)) / (∂h/∂t − a · ∂(R, V − V*)/∂t),   A a = ∂h/∂(u, P̂)
//!
//! ∂h is the second derivative of φ · (R, V − V*) along φ: a difference of its first at two states.
//!
//! Source: Govaerts 2000, "Numerical Methods for Bifurcations of Dynamical Equilibria", chapters 3 and 6; for
//! structures Godoy 2000, "Theory of Elastic Stability", chapter 5.

use mesh::Vec3;
use nalgebra::DMatrix;

use super::{Limit, factor_pinned, largest_entry, slopes};
use crate::forward::{Failure, Problem, Reached, Singularity, Workspace};
use crate::math::linear::dot;
use crate::stability::tangent_system::{Direction, LoadRate, Residual, across};

/// Motion of the difference that gives ∂h beside that of tangents: a slender body bends by little.
const SHORTER: f64 = 0.1;

/// dt = λ · ∂R + μ · ∂(V − V*) at some states: with the derivatives of the equations by anything there it gives that
/// of the load of a limit or a burst, or of the slope of the pressure.
#[derive(Clone, Debug)]
pub struct Covector {
    /// The state, by its load.
    pub at: Reached,
    /// λ over all degrees of freedom [1/N].
    pub lambda: Vec<f64>,
    /// μ [1/m³].
    pub mu: Vec<f64>,
}

impl Limit {
    /// What makes changes of the equations a change of the load: the sum of these.
    pub fn covectors(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
    ) -> Result<Vec<Covector>, Failure> {
        match self.kind {
            Singularity::LimitPoint => Ok(vec![self.covector(0.0, -1.0 / self.by_load)]),
            Singularity::Bifurcation => self.of_bifurcation(problem, workspace, rest),
        }
    }

    /// A multiple of the mode, at a state that is moved along it.
    fn covector(&self, moved: f64, factor: f64) -> Covector {
        let scaled = |x: &[f64], by: f64| x.iter().map(|x| by * x).collect();
        let mut at = self.at.clone();
        at.u.iter_mut().zip(&self.mode).for_each(|(u, v)| *u += moved * v);
        let pressures = at.multipliers.iter_mut().zip(&self.mode_pressures);
        pressures.for_each(|(m, p)| m.pressure += moved * p);
        let mu = scaled(&self.mode_pressures, -factor);
        Covector { at, lambda: scaled(&self.mode, factor), mu }
    }

    fn of_bifurcation(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
    ) -> Result<Vec<Covector>, Failure> {
        let state = self.at.configuration(rest, None);
        let at = state.iterate(problem);
        let constraints = Residual::of(problem, workspace, &at).constraints;
        let pressures = constraints.iter().map(|c| self.mode_pressures[c.multiplier]);
        let v = problem.restrict(&self.mode);
        let null = Direction { pressures: pressures.collect(), v };
        let (by_u, by_pressures, by_load) = slopes(problem, workspace, &state, &null);
        let rate = LoadRate::of(problem, workspace, &at);
        let pin = factor_pinned(problem, workspace, &at, largest_entry(&null.v)?)?;
        let mut columns = across(problem, &constraints);
        columns.push(null.v.clone());
        let count = columns.len();
        let mut lower = by_pressures;
        lower.push(0.0);
        let factor = workspace.linear().last().ok_or(Failure::Singular)?;
        let corner = DMatrix::zeros(count, count);
        let found = pin.solve(factor, columns.clone(), columns, corner, &by_u, lower);
        let (a, b) = found.ok_or(Failure::Singular)?;
        let c = by_load - dot(&a, &rate.force) + dot(&b[..count - 1], &rate.gaps);
        let mut of_path = self.covector(0.0, 0.0);
        of_path.lambda = problem.prolong(&a.iter().map(|a| a / c).collect::<Vec<_>>());
        for (constraint, b) in constraints.iter().zip(&b) {
            of_path.mu[constraint.multiplier] = -b / c;
        }
        let moved = SHORTER * null.step(&at);
        let by = 0.5 / (moved * c);
        Ok(vec![of_path, self.covector(moved, by), self.covector(-moved, -by)])
    }
}
