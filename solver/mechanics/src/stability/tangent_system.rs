//! The equations of an equilibrium with the load among the unknowns, and their derivatives:
//!
//! R(u, P̂, t) = ∂L/∂u = 0 on the free degrees of freedom,   V(u) − V*(t) = 0 of each prescribed volume
//!
//! with the Lagrangian L of prescribed volumes. Supports are where they are at t. The derivatives by t are
//! differences of the whole equations, so that no term has to know its own.

use nalgebra::DMatrix;

use super::bordered::Bordered;
use crate::energy::{Constraint, Hessian, Iterate};
use crate::forward::{Configuration, Failure, Problem, Workspace};
use crate::math::linear::{Factorization, Precision, dot, norm};

/// Half of the difference of loads that gives derivatives by the load. Most loads are linear in t: what counts is
/// rounding.
pub const DIFFERENCE: f64 = 1e-4;
/// Largest motion of the differences of tangents, beside the extent of the body.
const MOTION: f64 = 1e-5;
/// Fraction of the free path of surfaces that a step goes.
const NEARLY: f64 = 0.9;
/// Halvings of a step to a state with finite energy, at most.
const HALVINGS: usize = 12;

/// The equations at an iterate.
pub struct Residual {
    /// R on the free degrees of freedom [N].
    pub force: Vec<f64>,
    /// The scale of the forces that balance [N].
    pub scale: f64,
    /// The prescribed volumes.
    pub constraints: Vec<Constraint>,
}

impl Residual {
    /// The equations at an iterate.
    pub fn of(problem: &Problem, workspace: &mut Workspace, at: &Iterate) -> Self {
        let (gradient, scale) = workspace.gradient(problem, at);
        let constraints = problem.constraints(at);
        Self { force: problem.restrict(&gradient), scale, constraints }
    }

    /// Norm of R [N].
    pub fn norm(&self) -> f64 {
        norm(&self.force)
    }

    /// V − V* of each prescribed volume [m³].
    pub fn gaps(&self) -> Vec<f64> {
        self.constraints.iter().map(|c| c.volume - c.wanted).collect()
    }

    /// The largest |V/V* − 1|.
    pub fn largest_gap(&self) -> f64 {
        let gaps = self.constraints.iter().map(|c| (c.volume / c.wanted - 1.0).abs());
        gaps.fold(0.0, f64::max)
    }
}

/// What a unit of the load changes of the equations, with the free degrees of freedom and P̂ held.
pub struct LoadRate {
    /// ∂R/∂t [N].
    pub force: Vec<f64>,
    /// ∂(V − V*)/∂t [m³].
    pub gaps: Vec<f64>,
}

impl LoadRate {
    /// The derivative at an iterate, whose supports are where they are at its load. At t = 1 loads may bend.
    pub fn of(problem: &Problem, workspace: &mut Workspace, at: &Iterate) -> Self {
        let before = at.time - DIFFERENCE;
        let after = if at.time + DIFFERENCE > 1.0 { at.time } else { at.time + DIFFERENCE };
        let mut evaluate = |time: f64| {
            let u = with_supports(problem, at.u, time);
            let residual = Residual::of(problem, workspace, &Iterate { u: &u, time, ..*at });
            let gaps = residual.gaps();
            (residual.force, gaps)
        };
        let (from, to) = (evaluate(before), evaluate(after));
        let slope = |from: &[f64], to: &[f64]| -> Vec<f64> {
            from.iter().zip(to).map(|(a, b)| (b - a) / (after - before)).collect()
        };
        Self { force: slope(&from.0, &to.0), gaps: slope(&from.1, &to.1) }
    }

    /// Whether nothing depends on the load.
    pub fn vanishes(&self) -> bool {
        self.force.iter().chain(&self.gaps).all(|rate| *rate == 0.0)
    }
}

/// A displacement with the supports where they are at a load [m].
pub fn with_supports(problem: &Problem, u: &[f64], time: f64) -> Vec<f64> {
    let mut moved = u.to_vec();
    if problem.dirichlet.moves() {
        let wanted = problem.dirichlet.displacement(time);
        problem.dirichlet.supports().iter().for_each(|&dof| moved[dof] = wanted[dof]);
    }
    moved
}

/// Factors the exact Hessian at an iterate in double precision, whatever its inertia; none where it is not finite.
pub fn factor<'w>(
    problem: &Problem,
    workspace: &'w mut Workspace,
    at: &Iterate,
) -> Option<&'w Factorization> {
    let hessian = workspace.hessian(problem, at, Hessian::Exact);
    if !hessian.lower.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    workspace.factor(|linear| linear.factor(hessian, Precision::Double).is_positive());
    workspace.timings.factorizations += 1;
    workspace.linear().last()
}

/// One more equation of the unknowns, n · (δu, δt) = …
pub struct Row {
    /// n on the free degrees of freedom.
    pub u: Vec<f64>,
    /// n of the load.
    pub load: f64,
}

/// The tangent of the prescribed volumes alone, at a load that is held.
pub fn at_held_load(
    problem: &Problem,
    factor: &Factorization,
    constraints: &[Constraint],
) -> Bordered {
    let across = across(problem, constraints);
    let count = across.len();
    Bordered::new(factor, across.clone(), across, DMatrix::zeros(count, count))
}

/// The tangent of all equations by u, P̂ and t, with one more equation.
pub fn with_load(
    problem: &Problem,
    factor: &Factorization,
    constraints: &[Constraint],
    rate: &LoadRate,
    row: Row,
) -> Bordered {
    let mut columns = across(problem, constraints);
    let mut rows = columns.clone();
    let count = columns.len();
    let mut corner = DMatrix::zeros(count + 1, count + 1);
    for (i, gap) in rate.gaps.iter().enumerate() {
        corner[(i, count)] = -gap;
    }
    corner[(count, count)] = row.load;
    columns.push(rate.force.clone());
    rows.push(row.u);
    Bordered::new(factor, columns, rows, corner)
}

/// d(u, P̂, t) of the path, of which `row` says how long it is; none where the tangent is singular.
pub fn path_direction(
    problem: &Problem,
    factor: &Factorization,
    constraints: &[Constraint],
    rate: &LoadRate,
    row: Row,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let tangent = with_load(problem, factor, constraints, rate, row);
    let mut one = vec![0.0; constraints.len() + 1];
    one[constraints.len()] = 1.0;
    tangent.solve(factor, &vec![0.0; rate.force.len()], &one)
}

/// −∂V/∂u of each prescribed volume on the free degrees of freedom [m²]: ∂R/∂P̂.
pub fn across(problem: &Problem, constraints: &[Constraint]) -> Vec<Vec<f64>> {
    let negative = |c: &Constraint| problem.restrict(&c.gradient).iter().map(|g| -g).collect();
    constraints.iter().map(negative).collect()
}

/// Numbers of the prescribed volumes, by the places of their multipliers.
pub fn by_multiplier(count: usize, constraints: &[Constraint], values: &[f64]) -> Vec<f64> {
    let mut placed = vec![0.0; count];
    for (constraint, value) in constraints.iter().zip(values) {
        placed[constraint.multiplier] = *value;
    }
    placed
}

/// A direction of the unknowns: of the free degrees of freedom [m], and of the pressures of the prescribed volumes in
/// their order [Pa].
pub struct Direction {
    /// v.
    pub v: Vec<f64>,
    /// The pressures that go with v.
    pub pressures: Vec<f64>,
}

impl Direction {
    /// J v at an iterate: forces on the free degrees of freedom, and volumes.
    pub fn times_tangent(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        at: &Iterate,
    ) -> (Vec<f64>, Vec<f64>) {
        let hessian = workspace.hessian(problem, at, Hessian::Exact);
        let mut force = workspace.linear().multiply(&hessian, &self.v);
        workspace.recycle(hessian);
        let across = across(problem, &problem.constraints(at));
        for (column, pressure) in across.iter().zip(&self.pressures) {
            force.iter_mut().zip(column).for_each(|(f, c)| *f += pressure * c);
        }
        let volumes = across.iter().map(|row| dot(row, &self.v)).collect();
        (force, volumes)
    }

    /// (∂J/∂z · v) v, the second derivative of the equations along the direction: a difference of two tangents.
    pub fn curvature(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        state: &Configuration,
    ) -> (Vec<f64>, Vec<f64>) {
        let by = self.step(&state.iterate(problem));
        let mut at = |by: f64| {
            let moved = self.moved(problem, state, by);
            self.times_tangent(problem, workspace, &moved.iterate(problem))
        };
        let (plus, minus) = (at(by), at(-by));
        let slope = |plus: &[f64], minus: &[f64]| -> Vec<f64> {
            plus.iter().zip(minus).map(|(p, m)| (p - m) / (2.0 * by)).collect()
        };
        (slope(&plus.0, &minus.0), slope(&plus.1, &minus.1))
    }

    /// A state that is moved by a multiple of the direction.
    pub fn moved<'a>(
        &self,
        problem: &Problem,
        state: &Configuration<'a>,
        by: f64,
    ) -> Configuration<'a> {
        let mut moved = state.clone();
        let motion = problem.prolong(&self.v);
        moved.u.iter_mut().zip(&motion).for_each(|(u, v)| *u += by * v);
        let multipliers = moved.multipliers.iter_mut().zip(&self.pressures);
        multipliers.for_each(|(m, p)| m.pressure += by * p);
        moved
    }

    /// The multiple that differences of tangents move by.
    pub fn step(&self, at: &Iterate) -> f64 {
        let largest = self.v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        MOTION * extent(at) / largest.max(f64::MIN_POSITIVE)
    }
}

/// Diagonal of the body at rest [m].
pub fn extent(at: &Iterate) -> f64 {
    let corner =
        |pick: fn(f64, f64) -> f64| at.rest.iter().fold(at.rest[0], |m, x| m.zip_map(x, pick));
    (corner(f64::max) - corner(f64::min)).norm()
}

/// A step from a state.
pub struct Step<'a> {
    pub constraints: &'a [Constraint],
    /// Changes of the unknowns [m].
    pub du: Vec<f64>,
    /// Changes of the multipliers of the prescribed volumes in their order [Pa], and of the load, which may be none.
    pub rest: Vec<f64>,
}

impl<'a> Step<'a> {
    /// That of Newton's method with the exact tangent on all equations and one more, of which `off` is left.
    pub fn newton(
        problem: &Problem,
        workspace: &mut Workspace,
        at: &Iterate,
        now: &'a Residual,
        row: Row,
        off: f64,
    ) -> Result<Self, Failure> {
        let rate = LoadRate::of(problem, workspace, at);
        let factor = factor(problem, workspace, at).ok_or(Failure::Inadmissible)?;
        let tangent = with_load(problem, factor, &now.constraints, &rate, row);
        let upper: Vec<f64> = now.force.iter().map(|r| -r).collect();
        let mut lower = now.gaps();
        lower.push(-off);
        let (du, rest) = tangent.solve(factor, &upper, &lower).ok_or(Failure::Singular)?;
        Ok(Self { constraints: &now.constraints, du, rest })
    }

    /// The state after a fraction of it.
    pub fn from<'b>(
        &self,
        problem: &Problem,
        state: &Configuration<'b>,
        fraction: f64,
    ) -> Configuration<'b> {
        let by = |i: usize| fraction * self.rest.get(i).copied().unwrap_or(0.0);
        let time = state.time + by(self.constraints.len());
        let mut u = with_supports(problem, &state.u, time);
        u.iter_mut().zip(problem.prolong(&self.du)).for_each(|(u, d)| *u += fraction * d);
        let mut multipliers = state.multipliers.clone();
        for (i, constraint) in self.constraints.iter().enumerate() {
            multipliers[constraint.multiplier].pressure += by(i);
        }
        Configuration { time, u, multipliers, ..state.clone() }
    }

    /// The state after it, cut where surfaces meet or the energy is not finite.
    pub fn cut<'b>(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        state: &Configuration<'b>,
    ) -> Configuration<'b> {
        let (mut trial, mut fraction) = (self.from(problem, state, 1.0), 1.0);
        let free = workspace.max_step(problem, &state.iterate(problem), &trial.iterate(problem));
        if free < 1.0 {
            fraction = NEARLY * free;
            trial = self.from(problem, state, fraction);
        }
        for _ in 0..HALVINGS {
            if workspace.value(problem, &trial.iterate(problem)).is_finite() {
                break;
            }
            fraction *= 0.5;
            trial = self.from(problem, state, fraction);
        }
        trial
    }
}
