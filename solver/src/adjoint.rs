//! Gradient of an objective over a run, backwards through its time steps.
//!
//! Step n solves G(u_n; X, past_n, p) = ∂E/∂u = 0 on the free degrees of freedom,
//! where the past is what [`TimeStep`](crate::energy::TimeStep) holds:
//!
//! history = Σ αᵢ u₋ᵢ      free flight = Σ αᵢ (u₋ᵢ + h v₋ᵢ)
//! lagged contacts:   a function of u₋₁ and X      v_n = (u_n − history) / h
//!
//! With ū_n, v̄_n the cotangents of the state that later steps and the objective have
//! gathered, from the last step to the first:
//!
//! H λ = −(ū_n + v̄_n / h)      X̄ += λᵀ ∂²E/∂u∂X      p̄ += λᵀ ∂²E/∂u∂p
//! past̄ = λᵀ ∂²E/∂u∂past,  of the history also − v̄_n / h,  on to the states before
//!
//! with the exact Hessian H = ∂²E/∂u². A prescribed volume V(u, X) = V* is held by a
//! pressure, which is unknown, too; with G = ∂V/∂u and a number μ for each of them
//!
//! H λ + G μ = −(ū_n + v̄_n / h)      Gᵀ λ = 0      X̄ += μ ∂(V − V*)/∂X
//!
//! An objective may also look at the forces
//! f = −∂E_c/∂u of contact and friction; its ∂J/∂f acts like −λ in those terms.
//!
//! It is the chain rule for any formula and start. For one static step it is equation 5 of
//! Gjoka et al. 2024, section 3, who take the recursion through time from Huang et al.
//! 2023. One factorisation per step.

use std::time::Instant;

use mesh::Vec3;
use nalgebra::{DMatrix, DVector};

use crate::element::FunctionSpace;
use crate::energy::{Constraint, ParameterGradients, PastCotangent, Term};
use crate::forward::{State, System, Trajectory};
use crate::math::linear::{dot, norm};

/// Relative residual of the adjoint system that is too large.
const TOLERANCE: f64 = 1e-9;
/// The one that is sought.
const SOUGHT: f64 = 1e-12;

/// The adjoint system has no accurate solution.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error(
    "the adjoint system was solved only to a relative residual of {residual:.1e}, wanted {TOLERANCE:.0e}: the equilibrium is at a limit point or bifurcation"
)]
pub struct Singular {
    /// Relative residual reached.
    pub residual: f64,
}

/// Partial derivatives of the objective by what a moment looks like.
pub struct Partials {
    /// ∂J/∂u_n at fixed f, three components per node.
    pub by_u: Vec<f64>,
    /// ∂J/∂f_n by the nodal forces of contact and friction.
    pub by_contact: Vec<f64>,
}

/// dJ of a run, without ∂J/∂X, which the objective adds.
pub struct Gradient {
    /// By rest vertices, three components per vertex.
    pub rest: Vec<f64>,
    /// By the numbers that the energies are made with.
    pub parameters: ParameterGradients,
    /// By the state at t = 0.
    pub start: State,
}

/// Sweeps back through a run on a rest shape. `partials` adds the objective's at
/// moment n, 0 at the start, to zeros. `linearized` says that the system has a
/// factor of the Hessian at the last state.
///
/// # Errors
/// [`Singular`] when H has no accurate inverse at some step.
pub fn sweep(
    system: &mut System,
    rest: &[Vec3],
    run: &Trajectory,
    linearized: bool,
    mut partials: impl FnMut(&FunctionSpace, usize, &mut Partials),
) -> Result<Gradient, Singular> {
    let (len, steps) = (system.len(), run.steps());
    let mut rest_bar = vec![0.0; 3 * rest.len()];
    let mut parameters = ParameterGradients::new(steps);
    let mut states: Vec<Option<State>> = vec![None; steps + 1];
    for n in (1..=steps).rev() {
        let State { u, v } = states[n].take().unwrap_or_else(|| zeros(len));
        let mut own = Partials { by_u: u, by_contact: vec![0.0; len] };
        partials(&system.space, n, &mut own);
        let state = run.state(n);
        let at = Moment { rest, u: &state.u, load: run.times[n] };
        system.step = Some(run.step(system, rest, n));
        system.hold_volumes(rest, at.u, at.load);
        let sweep = Step { by_velocity: v, partials: own };
        let factored = linearized && n == steps;
        let solution = sweep.solve(system, &at, factored)?;
        let into = (&mut rest_bar[..], &mut parameters);
        let past = sweep.pull_back(system, &at, &solution, n, into);
        hand_on(system, rest, run, n, &past, &mut states, &mut rest_bar);
    }
    let State { u, v } = states[0].take().unwrap_or_else(|| zeros(len));
    let mut first = Partials { by_u: u, by_contact: vec![0.0; len] };
    partials(&system.space, 0, &mut first);
    Ok(Gradient { rest: rest_bar, parameters, start: State { u: first.by_u, v } })
}

fn zeros(len: usize) -> State {
    State { u: vec![0.0; len], v: vec![0.0; len] }
}

/// Where a step ends.
struct Moment<'a> {
    rest: &'a [Vec3],
    u: &'a [f64],
    load: f64,
}

/// Of the adjoint system of a step.
struct Solution {
    /// λ, zero on the fixed degrees of freedom.
    lambda: Vec<f64>,
    /// μ of each prescribed volume.
    mu: Vec<f64>,
}

/// What is known at a step before its adjoint system is solved.
struct Step {
    by_velocity: Vec<f64>,
    partials: Partials,
}

impl Step {
    fn solve(
        &self,
        system: &mut System,
        at: &Moment,
        factored: bool,
    ) -> Result<Solution, Singular> {
        let h = system.step.as_ref().expect("set by the sweep").h;
        let by_contact = &self.partials.by_contact;
        let through = system.contact_hessian_times(at.rest, at.u, at.load, by_contact);
        let sum = |d: usize| {
            let own = self.partials.by_u[d] + self.by_velocity[d] / h;
            -(own - through.as_ref().map_or(0.0, |t| t[d]))
        };
        let rhs = system.restrict(&(0..at.u.len()).map(sum).collect::<Vec<_>>());
        let constraints = system.constraints(at.rest, at.u, at.load);
        if norm(&rhs) == 0.0 {
            return Ok(Solution {
                lambda: vec![0.0; at.u.len()],
                mu: vec![0.0; constraints.len()],
            });
        }
        if !factored {
            system.linearize(at.rest, at.u, at.load);
        }
        let mut lambda = solve(system, rhs)?;
        let mu = hold(system, &constraints, &mut lambda)?;
        Ok(Solution { lambda: system.prolong(&lambda), mu })
    }

    /// The cotangent of the past; adds those of the rest shape and parameters.
    fn pull_back(
        &self,
        system: &System,
        at: &Moment,
        Solution { lambda, mu }: &Solution,
        n: usize,
        (rest_bar, parameters): (&mut [f64], &mut ParameterGradients),
    ) -> PastCotangent {
        let iterate = system.iterate(at.rest, at.u, at.load);
        let mut past = PastCotangent::zeros(at.u.len());
        let by_contact = &self.partials.by_contact;
        let in_contact: Vec<f64> = lambda.iter().zip(by_contact).map(|(l, f)| l - f).collect();
        for Term { kind, energy } in system.energies.terms() {
            let lambda = if kind.is_contact() { &in_contact } else { lambda };
            energy.add_mixed_vjp(&iterate, lambda, rest_bar);
            energy.add_past_vjp(&iterate, lambda, &mut past);
            let mut by = energy.parameter_vjp(&iterate, lambda);
            by.extend(energy.constraint_vjp(&iterate, mu, rest_bar));
            if let Some(id) = kind.parameter() {
                parameters.add(n - 1, id, by);
            }
        }
        let h = system.step.as_ref().expect("set by the sweep").h;
        past.history.iter_mut().zip(&self.by_velocity).for_each(|(p, v)| *p -= v / h);
        past
    }
}

/// H⁻¹ of a vector over the free degrees of freedom.
fn solve(system: &mut System, rhs: Vec<f64>) -> Result<Vec<f64>, Singular> {
    let start = Instant::now();
    let mut x = rhs.clone();
    let mut residual = system.linear.solve_to(&mut x, SOUGHT);
    if (residual.is_nan() || residual > TOLERANCE) && system.linear.sharpen() {
        x = rhs;
        residual = system.linear.solve_to(&mut x, SOUGHT);
    }
    system.timings.solve_s += start.elapsed().as_secs_f64();
    if residual.is_nan() || residual > TOLERANCE {
        return Err(Singular { residual });
    }
    Ok(x)
}

/// Takes G μ out of the adjoint system: λ becomes λ − H⁻¹ G μ with Gᵀ λ = 0. The penalty
/// in H does not matter, for it acts along G only.
fn hold(
    system: &mut System,
    constraints: &[Constraint],
    lambda: &mut [f64],
) -> Result<Vec<f64>, Singular> {
    let count = constraints.len();
    let mut mu = vec![0.0; count];
    if count == 0 {
        return Ok(mu);
    }
    let across: Vec<Vec<f64>> = constraints.iter().map(|c| system.restrict(&c.gradient)).collect();
    let solved = across.iter().map(|g| solve(system, g.clone()));
    let solved: Vec<Vec<f64>> = solved.collect::<Result<_, _>>()?;
    let matrix = DMatrix::from_fn(count, count, |i, j| dot(&across[i], &solved[j]));
    let side = DVector::from_fn(count, |i, _| dot(&across[i], lambda));
    let by_constraint = matrix.lu().solve(&side).ok_or(Singular { residual: f64::INFINITY })?;
    for ((constraint, z), by) in constraints.iter().zip(&solved).zip(by_constraint.iter()) {
        lambda.iter_mut().zip(z).for_each(|(l, z)| *l -= by * z);
        mu[constraint.multiplier] = *by;
    }
    Ok(mu)
}

/// Hands the cotangent of the past of step n on to the states before it.
fn hand_on(
    system: &System,
    rest: &[Vec3],
    run: &Trajectory,
    n: usize,
    past: &PastCotangent,
    states: &mut [Option<State>],
    rest_bar: &mut [f64],
) {
    let h = system.step.as_ref().expect("set by the sweep").h;
    let integrator = run.past(n);
    for (i, alpha) in integrator.formula().0.iter().enumerate() {
        let state = states[n - 1 - i].get_or_insert_with(|| zeros(system.len()));
        for d in 0..system.len() {
            let flight = past.free_flight[d];
            state.u[d] += alpha * (past.history[d] + flight);
            state.v[d] += alpha * h * flight;
        }
    }
    if past.lagged_contacts.is_empty() {
        return;
    }
    let last = run.state(n - 1);
    let before = system.iterate(rest, &last.u, run.times[n - 1]);
    let state = states[n - 1].get_or_insert_with(|| zeros(system.len()));
    for energy in system.energies.iter() {
        energy.add_lagged_contacts_vjp(&before, &past.lagged_contacts, &mut state.u, rest_bar);
    }
}

#[cfg(test)]
mod tests;
