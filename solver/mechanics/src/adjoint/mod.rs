//! Adjoint method: the gradient of an objective over a run (design sensitivities),
//! backwards through its time steps (reverse mode).
//!
//! Step n solves G(u_n; X, past_n, p) = ∂E/∂u = 0 on the free degrees of freedom,
//! where the past is that of a [`TimeStep`]:
//!
//! history, free flight, Z°:   sums over the states before, with the weights of a formula
//! lagged contacts:            a function of u₋₁ and X
//! v_n = (u_n − history) / h             a_n = (u_n − free flight) / s
//! internal variables Z:       functions of u, X, p and Z°
//!
//! With ū_n, v̄_n, ā_n the cotangents of the state that later steps and the objective have
//! gathered, from the last step to the first:
//!
//! H λ = −(ū_n + v̄_n / h + ā_n / s)      X̄ += λᵀ ∂²E/∂u∂X      p̄ += λᵀ ∂²E/∂u∂p
//! past̄ = λᵀ ∂²E/∂u∂past,  of the history also − v̄_n / h, of the free flight − ā_n / s,
//! on to the states before by the same weights
//!
//! with the exact Hessian H = ∂²E/∂u². The pressure of a prescribed volume V(u, X) = V*,
//! its Lagrange multiplier, is unknown, too; with G = ∂V/∂u and a number μ for each of them
//!
//! H λ + G μ = −(ū_n + v̄_n / h + ā_n / s)      Gᵀ λ = 0      X̄ += μ ∂(V − V*)/∂X
//!
//! An objective may also depend on the forces
//! f = −∂E_c/∂u of contact and friction; its ∂J/∂f acts like −λ in those terms. It may depend
//! on the forces r = ∂E/∂u of supports, on the degrees of freedom that they fix; its ∂J/∂r is
//! λ there, where λ is zero otherwise.
//!
//! It is the chain rule for any formula and start. For one static step it is equation 5 of
//! Gjoka et al. 2024, section 3, who take the recursion through time from Huang et al.
//! 2023. One factorisation per step.

mod scaled_pressure;

use mesh::Vec3;

use crate::element::FunctionSpace;
use crate::energy::{
    Constraint, Contact, Friction, Iterate, ParameterGradients, PastCotangent, Term, TimeStep,
};
use crate::forward::{
    Event, Formula, HeldVolumes, Linearization, Linearizations, Problem, State, Trajectory,
    Workspace, solve_multipliers,
};
use crate::math::linear::{dot, norm};

pub use scaled_pressure::ScaledPressure;

/// Relative residual of the adjoint system that is too large.
const TOLERANCE: f64 = 1e-9;
/// The one that is sought.
const SOUGHT: f64 = 1e-12;

/// Why there is no gradient.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum NoGradient {
    /// The adjoint system has no accurate solution.
    #[error(
        "the adjoint system was solved only to a relative residual of {residual:.1e}, wanted {TOLERANCE:.0e}: the equilibrium is at a limit point or bifurcation"
    )]
    Singular {
        /// Relative residual reached.
        residual: f64,
    },
    /// The watch has broken off.
    #[error("interrupted")]
    Interrupted,
}

/// Partial derivatives of the objective by what a moment looks like.
pub struct Partials {
    /// ∂J/∂u_n at fixed f and r, three components per node.
    pub by_u: Vec<f64>,
    /// ∂J/∂f_n by the nodal forces of contact and friction.
    pub by_contact: Vec<f64>,
    /// ∂J/∂r_n by the forces of supports, zero on free degrees of freedom.
    pub by_reaction: Vec<f64>,
}

impl Partials {
    fn new(by_u: Vec<f64>) -> Self {
        let (by_contact, by_reaction) = (vec![0.0; by_u.len()], vec![0.0; by_u.len()]);
        Self { by_u, by_contact, by_reaction }
    }
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

/// What of a gradient is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// All of it.
    All,
    /// Not [`Gradient::parameters`], which then mean nothing.
    Shape,
    /// Not [`Gradient::rest`], which then means nothing.
    Numbers,
}

/// Sweeps back through a run on a rest shape, for what is wanted of the gradient. `partials` adds the objective's at
/// moment n, 0 at the start, to zeros. Each linearisation whose factor is at hand saves one factorisation.
pub fn sweep(
    problem: &Problem,
    workspace: &mut Workspace,
    (rest, run): (&[Vec3], &Trajectory),
    linearizations: &Linearizations,
    wanted: Wanted,
    mut partials: impl FnMut(&FunctionSpace, usize, &mut Partials),
) -> Result<Gradient, NoGradient> {
    let (len, steps) = (problem.dofs(), run.steps());
    let mut rest_bar = vec![0.0; 3 * rest.len()];
    let mut parameters = ParameterGradients::new(steps);
    let mut states: Vec<Option<State>> = vec![None; steps + 1];
    for n in (1..=steps).rev() {
        if workspace.notify(&Event::Adjoint { step: n }).is_break() {
            return Err(NoGradient::Interrupted);
        }
        let State { u, v, a, internal } = states[n].take().unwrap_or_else(|| zeros(len));
        let mut own = Partials::new(u);
        partials(&problem.space, n, &mut own);
        let (state, step) = (run.state(n), run.step(problem, rest, n));
        let at = problem.iterate(rest, &state.u, run.times[n]);
        let at = Iterate { step: Some(&step), ..at };
        let multipliers = solve_multipliers(problem, workspace, &at);
        let at = Iterate { multipliers: &multipliers, ..at };
        let by_u = &mut own.by_u;
        let before =
            internal_vjp(problem, &at, &internal, n - 1, by_u, &mut rest_bar, &mut parameters);
        let (by_velocity, by_acceleration) = (v, a);
        let moment =
            Moment { at, step: &step, by_velocity, by_acceleration, partials: own, wanted };
        let solution = moment.solve(problem, workspace, linearizations.step(n))?;
        let mut past = moment.vjp(problem, &solution, n - 1, &mut rest_bar, &mut parameters);
        add_where_any(&mut past.internal, &before, 1.0);
        past_vjp(problem, rest, run, n, &past, &mut states, &mut rest_bar);
    }
    let State { u, v, .. } = states[0].take().unwrap_or_else(|| zeros(len));
    let mut first = Partials::new(u);
    partials(&problem.space, 0, &mut first);
    Ok(Gradient { rest: rest_bar, parameters, start: State::new(first.by_u, v) })
}

/// λᵀ ∂²E/∂u∂X, three components per vertex, with μ ∂(V − V*)/∂X of the prescribed volumes, and the same by the numbers
/// that the energies are made with, as those of one time step: what a change of the rest shape or of the numbers does to
/// the equations of a state, along λ and μ.
pub fn along(
    problem: &Problem,
    at: &Iterate,
    lambda: &[f64],
    mu: &[f64],
) -> (Vec<f64>, ParameterGradients) {
    let (mut rest_bar, mut parameters) = (vec![0.0; 3 * at.rest.len()], ParameterGradients::new(1));
    for term in problem.energies.terms() {
        term.energy.add_mixed_vjp(at, lambda, &mut rest_bar);
        let mut by = term.energy.parameter_vjp(at, lambda);
        by.extend(term.energy.constraint_vjp(at, mu, &mut rest_bar));
        add_parameters(term, 0, by, &mut parameters);
    }
    (rest_bar, parameters)
}

fn zeros(len: usize) -> State {
    State::new(vec![0.0; len], vec![0.0; len])
}

/// Solution of the adjoint system of a step.
struct Solution {
    /// λ, on the fixed degrees of freedom ∂J/∂r.
    lambda: Vec<f64>,
    /// μ of each prescribed volume.
    mu: Vec<f64>,
}

/// Where a step ends, and what is known there before its adjoint system is solved.
struct Moment<'a> {
    at: Iterate<'a>,
    step: &'a TimeStep,
    by_velocity: Vec<f64>,
    /// Empty where later steps do not depend on the acceleration.
    by_acceleration: Vec<f64>,
    partials: Partials,
    wanted: Wanted,
}

impl Moment<'_> {
    /// Displacement by acceleration [s²].
    fn square(&self) -> f64 {
        self.step.free_flight.as_ref().map_or(f64::INFINITY, |flight| flight.square)
    }

    fn solve(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        linearization: Option<&Linearization>,
    ) -> Result<Solution, NoGradient> {
        let Partials { by_u, by_contact, by_reaction } = &self.partials;
        let at = &self.at;
        let through = workspace.contact_hessian_times(problem, at, by_contact);
        let held = workspace.support_hessian_times(problem, at, by_reaction);
        let part = |product: &Option<Vec<f64>>, d: usize| product.as_ref().map_or(0.0, |t| t[d]);
        let by_acceleration =
            |d: usize| self.by_acceleration.get(d).map_or(0.0, |a| a / self.square());
        let sum = |d: usize| {
            let own = by_u[d] + self.by_velocity[d] / self.step.h + by_acceleration(d);
            -(own - part(&through, d) + part(&held, d))
        };
        let rhs = problem.restrict(&(0..at.u.len()).map(sum).collect::<Vec<_>>());
        let constraints = problem.constraints(at);
        if norm(&rhs) == 0.0 {
            return Ok(Solution { lambda: by_reaction.clone(), mu: vec![0.0; constraints.len()] });
        }
        if !linearization.is_some_and(|l| workspace.has_factor_of(l, at)) {
            workspace.linearize(problem, at);
        }
        let mut free = solve(workspace, rhs)?;
        let mu = eliminate_constraints(problem, workspace, &constraints, &mut free, by_reaction)?;
        let mut lambda = problem.prolong(&free);
        lambda.iter_mut().zip(by_reaction).for_each(|(l, r)| *l += r);
        Ok(Solution { lambda, mu })
    }

    /// The cotangent of the past; adds those of the rest shape and of the parameters in
    /// a time step counted from 0.
    fn vjp(
        &self,
        problem: &Problem,
        Solution { lambda, mu }: &Solution,
        step: usize,
        rest_bar: &mut [f64],
        parameters: &mut ParameterGradients,
    ) -> PastCotangent {
        let at = &self.at;
        let mut past = PastCotangent::zeros(at.u.len());
        let by_contact = &self.partials.by_contact;
        let in_contact: Vec<f64> = lambda.iter().zip(by_contact).map(|(l, f)| l - f).collect();
        for term in problem.energies.terms() {
            let energy = &term.energy;
            let is_contact = term.nature().is_contact();
            let own = if is_contact { &in_contact } else { lambda };
            energy.add_past_vjp(at, own, &mut past);
            if self.wanted != Wanted::Numbers {
                energy.add_mixed_vjp(at, own, rest_bar);
            }
            let mut by = match self.wanted {
                Wanted::Shape => Vec::new(),
                _ => energy.parameter_vjp(at, own),
            };
            by.extend(energy.constraint_vjp(at, mu, rest_bar));
            if self.wanted != Wanted::Shape {
                add_parameters(term, step, by, parameters);
            }
        }
        let energies = &problem.energies;
        let friction = energies.each::<Friction>().next();
        if let (Some(contact), Some(_)) = (energies.contact(), friction) {
            let lagged = &self.step.lagged_contacts;
            let by = contact.lagged_stiffness_vjp(lagged, &past.lagged_contacts);
            parameters.add(step, Contact::OWNER, vec![by]);
        }
        let (h, square) = (self.step.h, self.square());
        past.history.iter_mut().zip(&self.by_velocity).for_each(|(p, v)| *p -= v / h);
        past.free_flight.iter_mut().zip(&self.by_acceleration).for_each(|(p, a)| *p -= a / square);
        past
    }
}

/// Pulls back cotangents of the internal variables of a state to the state, the rest shape and the
/// parameters in a time step counted from 0, to which it adds. The result is the cotangent of Z° of the
/// step; empty where there are none.
fn internal_vjp(
    problem: &Problem,
    at: &Iterate,
    cotangents: &[f64],
    step: usize,
    by_u: &mut [f64],
    rest_bar: &mut [f64],
    parameters: &mut ParameterGradients,
) -> Vec<f64> {
    let mut past = Vec::new();
    if cotangents.is_empty() {
        return past;
    }
    for term in problem.energies.terms() {
        let Some(variables) = term.energy.internal_variables() else { continue };
        let by = variables.add_vjp(at, cotangents, by_u, rest_bar);
        past.extend(by.past);
        add_parameters(term, step, by.parameters, parameters);
    }
    past
}

/// Adds the derivatives by the numbers that a term is made with, owner by owner.
fn add_parameters(term: &Term, step: usize, mut by: Vec<f64>, parameters: &mut ParameterGradients) {
    for &(owner, count) in &term.owners {
        let rest = by.split_off(count.min(by.len()));
        parameters.add(step, owner, by);
        by = rest;
    }
}

/// Adds a multiple of some numbers to others, of which there may be none yet.
fn add_where_any(to: &mut Vec<f64>, by: &[f64], factor: f64) {
    if to.is_empty() {
        to.resize(by.len(), 0.0);
    }
    to.iter_mut().zip(by).for_each(|(to, by)| *to += factor * by);
}

/// H⁻¹ of a vector over the free degrees of freedom, by the last factorisation.
fn solve(workspace: &mut Workspace, mut x: Vec<f64>) -> Result<Vec<f64>, NoGradient> {
    let reached = workspace.solve_accurately(&mut x, SOUGHT, TOLERANCE);
    let residual = reached.unwrap_or(f64::INFINITY);
    if residual.is_nan() || residual > TOLERANCE {
        return Err(NoGradient::Singular { residual });
    }
    Ok(x)
}

/// Eliminates G μ from the adjoint system: λ becomes λ − H⁻¹ G μ with Gᵀ λ = 0, where λ is
/// `held` on the fixed degrees of freedom. The penalty in H does not matter, for it acts along G
/// only.
fn eliminate_constraints(
    problem: &Problem,
    workspace: &mut Workspace,
    constraints: &[Constraint],
    lambda: &mut [f64],
    held: &[f64],
) -> Result<Vec<f64>, NoGradient> {
    let across: Vec<Vec<f64>> = constraints.iter().map(|c| problem.restrict(&c.gradient)).collect();
    let solved = across.iter().map(|g| solve(workspace, g.clone()));
    let solved: Vec<Vec<f64>> = solved.collect::<Result<_, _>>()?;
    let on_held = |i: usize| -dot(&constraints[i].gradient, held);
    let weights = HeldVolumes::new(across, solved).hold(lambda, on_held);
    let weights = weights.ok_or(NoGradient::Singular { residual: f64::INFINITY })?;
    let mut mu = vec![0.0; constraints.len()];
    for (constraint, weight) in constraints.iter().zip(weights) {
        mu[constraint.multiplier] = -weight;
    }
    Ok(mu)
}

/// Adds the cotangent of the past of step n to those of the states before it.
fn past_vjp(
    problem: &Problem,
    rest: &[Vec3],
    run: &Trajectory,
    n: usize,
    past: &PastCotangent,
    states: &mut [Option<State>],
    rest_bar: &mut [f64],
) {
    let len = problem.dofs();
    let Formula { h, past: weights, .. } = run.past(n).formula(run.times[n] - run.times[n - 1]);
    for (i, weights) in weights.iter().enumerate() {
        let state = states[n - 1 - i].get_or_insert_with(|| zeros(len));
        let [by_u, by_v, by_a] = weights.history;
        let [flight_by_v, flight_by_a] = weights.velocity.map(|by| by * h);
        if by_a != 0.0 || flight_by_a != 0.0 {
            state.a.resize(len, 0.0);
        }
        for d in 0..len {
            let flight = past.free_flight[d];
            let history = past.history[d] + flight;
            state.u[d] += by_u * history;
            state.v[d] += by_v * history + flight_by_v * flight;
            if let Some(a) = state.a.get_mut(d) {
                *a += by_a * history + flight_by_a * flight;
            }
        }
        add_where_any(&mut state.internal, &past.internal, weights.internal);
    }
    if past.lagged_contacts.is_empty() {
        return;
    }
    let last = run.state(n - 1);
    let before = problem.iterate(rest, &last.u, run.times[n - 1]);
    let state = states[n - 1].get_or_insert_with(|| zeros(len));
    if let Some(contact) = problem.energies.contact() {
        contact.add_lagged_contacts_vjp(&before, &past.lagged_contacts, &mut state.u, rest_bar);
    }
}

#[cfg(test)]
mod tests;
