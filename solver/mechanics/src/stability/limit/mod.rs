//! Loads at which an equilibrium loses its stability, by a direct method.
//!
//! The state is sought at which the tangent J of forces and prescribed volumes is singular,
//!
//! R(u, P̂, t) = 0,   V = V*,   J φ = 0,   |φ| = 1
//!
//! as an equation g = 0 more, with a vector b near φ and |b| = 1 (the minimally extended system, which has the solutions
//! of the one above):
//!
//! J v + b g = 0,   b · v = 1,   ∂g/∂z = −v · (∂J/∂z) v
//!
//! so that v becomes φ. Newton's method converges quadratically from a state near by. ∂J/∂z v is a difference of
//! two tangents. At a limit point the system is regular. At a bifurcation of a symmetric body it is not, as φ has no
//! share in what moves there: that share is then held, by a force along φ. It comes out as zero if the mesh is
//! symmetrical, too; else it is the imperfection that the mesh makes, and the load that of the body without it.
//!
//! Source: Moore and Spence 1980, doi:10.1137/0717048; Griewank and Reddien 1984, doi:10.1093/imanum/4.3.295; Wriggers
//! and Simo 1990, doi:10.1002/nme.1620300110; Govaerts 2000, "Numerical Methods for Bifurcations of Dynamical
//! Equilibria", chapters 3 and 4.

mod derivative;
mod load_steps;
mod search;

pub use derivative::Covector;
pub use search::{FirstLimit, LimitSearch};

use nalgebra::DMatrix;

use crate::energy::{Constraint, Hessian, Iterate};
use crate::forward::{Configuration, Failure, Newton, Problem, Reached, Singularity, Workspace};
use crate::math::linear::{Factorization, Precision, dot, norm};
use crate::stability::bordered::Bordered;
use crate::stability::spectrum::{negative_eigenvalues, softest};
use crate::stability::tangent_system::{
    DIFFERENCE, Direction, LoadRate, Residual, Step, across, at_held_load, by_multiplier, factor,
    with_supports,
};

/// Newton iterations, at most.
const ITERATIONS: usize = 25;
/// Steps back to the path after one of them, at most ...
const CORRECTIONS: usize = 8;
/// ... where the residual is more than this part of the forces.
const ROUGH: f64 = 1e-5;
/// Relative change of the load that is none.
const SETTLED: f64 = 1e-9;

/// An equilibrium at which the tangent is singular.
#[derive(Clone, Debug)]
pub struct Limit {
    /// The state, by its load.
    pub at: Reached,
    /// φ over all degrees of freedom.
    pub mode: Vec<f64>,
    /// Pressures of prescribed volumes that go with φ [Pa/m].
    pub mode_pressures: Vec<f64>,
    /// φ · ∂R/∂t of all equations, what a unit of the load does along φ [N].
    pub by_load: f64,
    /// Whether the load turns or a branch leaves.
    pub kind: Singularity,
    /// Negative eigenvalues with the softest mode held: none at the first limit of a path.
    pub others: usize,
    /// What each iterate left.
    pub history: Vec<DirectIterate>,
}

/// What an iterate of the direct method leaves of its equations.
#[derive(Clone, Copy, Debug)]
pub struct DirectIterate {
    /// Norm of the unbalanced force [N]; at a bifurcation but for its part along the mode.
    pub residual: f64,
    /// g, the stiffness of the softest mode [N/m].
    pub stiffness: f64,
    /// Load.
    pub load: f64,
}

/// v with the pressures that go with it, and g.
struct Null {
    direction: Direction,
    stiffness: f64,
}

impl Null {
    /// The share of the mode in what a unit of the load does to the equations.
    fn along(&self, rate: &LoadRate) -> f64 {
        let Direction { v, pressures } = &self.direction;
        dot(v, &rate.force) - dot(pressures, &rate.gaps)
    }
}

impl Limit {
    /// The state of the given kind next to a state.
    pub fn near(
        problem: &Problem,
        workspace: &mut Workspace,
        start: &Configuration,
        kind: Singularity,
        newton: &Newton,
    ) -> Result<Self, Failure> {
        let mut state = start.clone();
        let mut mode = first_mode(problem, workspace, &state.iterate(problem))?;
        let pinned = largest_entry(&mode)?;
        let held = Sought { mode: &mode, kind, pin: &Pin { unknown: pinned, stiffness: 0.0 } };
        state = back_to_path(problem, workspace, state, &held, newton)?;
        let (mut history, mut changed, mut peak) = (Vec::new(), f64::INFINITY, 0.0_f64);
        for iterations in 0..=ITERATIONS {
            let at = state.iterate(problem);
            let now = Residual::of(problem, workspace, &at);
            peak = peak.max(now.scale);
            let residual = norm(&beside(&now.force, &mode, kind));
            let wanted = newton.wanted(now.scale, peak);
            if !residual.is_finite() {
                return Err(Failure::Inadmissible);
            }
            let rough = wanted.max(ROUGH * now.scale);
            if iterations == 0 && residual > rough {
                // not on a path: Newton's method would go astray
                return Err(Failure::IterationLimit { iterations, residual, wanted: rough });
            }
            let pin = factor_pinned(problem, workspace, &at, pinned)?;
            let null = null_vector(problem, workspace, &now.constraints, &mode, &pin)?;
            log::debug!("limit {iterations}  |g| {residual:.2e} N  {:.2e} N/m", null.stiffness);
            history.push(DirectIterate { residual, stiffness: null.stiffness, load: state.time });
            let settled = changed <= SETTLED * state.time.abs()
                && now.largest_gap() <= newton.relative
                && (residual <= wanted || residual <= workspace.rounding_floor(problem, &at));
            if settled {
                let factor = workspace.linear().last().ok_or(Failure::Singular)?;
                let others =
                    negative_eigenvalues(factor, &at_held_load(problem, factor, &now.constraints));
                let by_load = null.along(&LoadRate::of(problem, workspace, &at));
                let Direction { v, pressures } = &null.direction;
                let count = state.multipliers.len();
                let mode_pressures = by_multiplier(count, &now.constraints, pressures);
                let (mode, at) = (problem.prolong(v), Reached::of(&at));
                return Ok(Self { at, mode, mode_pressures, by_load, kind, others, history });
            }
            if iterations == ITERATIONS {
                return Err(Failure::IterationLimit { iterations, residual, wanted });
            }
            let sought = Sought { mode: &mode, kind, pin: &pin };
            let before = state.time;
            state = sought.step(problem, workspace, &state, &now, Some(&null))?;
            state = back_to_path(problem, workspace, state, &sought, newton)?;
            changed = (state.time - before).abs();
            let v = &null.direction.v;
            let length = norm(v);
            mode = v.iter().map(|v| v / length).collect();
        }
        unreachable!("the last iteration returns")
    }
}

/// A degree of freedom that a stiffness beside that of the body holds, so that the factored matrix is regular: it is
/// taken away again as a row and a column around it.
struct Pin {
    unknown: usize,
    stiffness: f64,
}

impl Pin {
    /// The solution with the rows and columns around the tangent, D in `corner`, by the last factorisation.
    fn solve(
        &self,
        factor: &Factorization,
        mut columns: Vec<Vec<f64>>,
        mut rows: Vec<Vec<f64>>,
        corner: DMatrix<f64>,
        upper: &[f64],
        mut lower: Vec<f64>,
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let unit = |value: f64| {
            let mut unit = vec![0.0; upper.len()];
            unit[self.unknown] = value;
            unit
        };
        columns.push(unit(-self.stiffness));
        rows.push(unit(1.0));
        lower.push(0.0);
        let count = corner.nrows();
        let mut corner = corner.resize(count + 1, count + 1, 0.0);
        corner[(count, count)] = -1.0;
        let bordered = Bordered::new(factor, columns, rows, corner);
        let (x, mut y) = bordered.solve(factor, upper, &lower)?;
        y.pop();
        Some((x, y))
    }
}

/// Factors the exact Hessian with one degree of freedom held by as much stiffness again as it has.
fn factor_pinned(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    unknown: usize,
) -> Result<Pin, Failure> {
    let mut hessian = workspace.hessian(problem, at, Hessian::Exact);
    if !hessian.lower.iter().all(|entry| entry.is_finite()) {
        return Err(Failure::Inadmissible);
    }
    let entry = workspace.diagonal()[unknown];
    let stiffness = hessian.lower[entry].abs();
    hessian.lower[entry] += stiffness;
    workspace.factor(|linear| linear.factor(hessian, Precision::Double).is_positive());
    Ok(Pin { unknown, stiffness })
}

/// A force without its part along a mode, where that is held.
fn beside(force: &[f64], mode: &[f64], kind: Singularity) -> Vec<f64> {
    let along = if kind == Singularity::Bifurcation { dot(force, mode) } else { 0.0 };
    force.iter().zip(mode).map(|(f, m)| f - along * m).collect()
}

/// The degree of freedom that a mode moves most.
fn largest_entry(mode: &[f64]) -> Result<usize, Failure> {
    let largest = (0..mode.len()).max_by(|&a, &b| mode[a].abs().total_cmp(&mode[b].abs()));
    largest.ok_or(Failure::Singular)
}

/// The softest mode on the free degrees of freedom, to begin with.
fn first_mode(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
) -> Result<Vec<f64>, Failure> {
    let constraints = problem.constraints(at);
    let factor = factor(problem, workspace, at).ok_or(Failure::Inadmissible)?;
    let held = at_held_load(problem, factor, &constraints);
    softest(factor, &held).map(|(_, mode)| mode).ok_or(Failure::Singular)
}

/// v of the tangent that is factored.
fn null_vector(
    problem: &Problem,
    workspace: &Workspace,
    constraints: &[Constraint],
    mode: &[f64],
    pin: &Pin,
) -> Result<Null, Failure> {
    let factor = workspace.linear().last().ok_or(Failure::Singular)?;
    let mut columns = across(problem, constraints);
    columns.push(mode.to_vec());
    let count = columns.len();
    let mut one = vec![0.0; count];
    one[count - 1] = 1.0;
    let zero = vec![0.0; mode.len()];
    let corner = DMatrix::zeros(count, count);
    let found = pin.solve(factor, columns.clone(), columns, corner, &zero, one);
    let (v, mut pressures) = found.ok_or(Failure::Singular)?;
    let g = pressures.pop().ok_or(Failure::Singular)?;
    Ok(Null { direction: Direction { v, pressures }, stiffness: -g })
}

/// ∂g/∂u, ∂g/∂P̂ and ∂g/∂t.
fn slopes(
    problem: &Problem,
    workspace: &mut Workspace,
    state: &Configuration,
    null: &Direction,
) -> (Vec<f64>, Vec<f64>, f64) {
    let (by_u, by_pressures) = null.curvature(problem, workspace, state);
    let negative = |x: Vec<f64>| x.iter().map(|x| -x).collect();
    let mut loaded = |time: f64| {
        let u = with_supports(problem, &state.u, time);
        let at = Iterate { u: &u, time, ..state.iterate(problem) };
        let (force, volumes) = null.times_tangent(problem, workspace, &at);
        dot(&force, &null.v) + dot(&volumes, &null.pressures)
    };
    let by_load = -(loaded(state.time) - loaded(state.time - DIFFERENCE)) / DIFFERENCE;
    (negative(by_u), negative(by_pressures), by_load)
}

/// What is sought, and how the last factorisation is to be used.
struct Sought<'a> {
    mode: &'a [f64],
    kind: Singularity,
    pin: &'a Pin,
}

impl Sought<'_> {
    /// One step of Newton's method at a state whose tangent is factored: to the singular state, or without a null
    /// vector to the path, with the softest mode held at a limit point and the load at a bifurcation.
    fn step<'a>(
        &self,
        problem: &Problem,
        workspace: &mut Workspace,
        state: &Configuration<'a>,
        now: &Residual,
        null: Option<&Null>,
    ) -> Result<Configuration<'a>, Failure> {
        let rate = LoadRate::of(problem, workspace, &state.iterate(problem));
        let volumes = now.constraints.len();
        let holds = usize::from(self.kind == Singularity::Bifurcation);
        let mut corner = DMatrix::zeros(volumes + 1 + holds, volumes + 1 + holds);
        for i in 0..volumes {
            corner[(i, volumes)] = -rate.gaps[i];
        }
        let mut lower = now.gaps();
        let row = match null {
            Some(null) => {
                let (by_u, by_pressure, by_load) =
                    slopes(problem, workspace, state, &null.direction);
                (0..volumes).for_each(|i| corner[(volumes, i)] = by_pressure[i]);
                corner[(volumes, volumes)] = by_load;
                lower.push(null.stiffness);
                by_u
            }
            None if holds > 0 => {
                corner[(volumes, volumes)] = 1.0;
                lower.push(0.0);
                vec![0.0; self.mode.len()]
            }
            None => {
                lower.push(0.0);
                self.mode.to_vec()
            }
        };
        let mut columns = across(problem, &now.constraints);
        let mut rows = columns.clone();
        columns.push(rate.force);
        rows.push(row);
        if holds > 0 {
            columns.push(self.mode.to_vec());
            rows.push(self.mode.to_vec());
            lower.push(0.0);
        }
        let upper: Vec<f64> = now.force.iter().map(|r| -r).collect();
        let factor = workspace.linear().last().ok_or(Failure::Singular)?;
        let found = self.pin.solve(factor, columns, rows, corner, &upper, lower);
        let (du, rest) = found.ok_or(Failure::Singular)?;
        let step = Step { constraints: &now.constraints, du, rest };
        Ok(step.cut(problem, workspace, state))
    }
}

/// A state that a step has left the path with, back on it roughly: near incompressibility, the forces after a step are
/// many times those that balance, and the next one would go astray.
fn back_to_path<'a>(
    problem: &Problem,
    workspace: &mut Workspace,
    mut state: Configuration<'a>,
    sought: &Sought,
    newton: &Newton,
) -> Result<Configuration<'a>, Failure> {
    for _ in 0..CORRECTIONS {
        let at = state.iterate(problem);
        let now = Residual::of(problem, workspace, &at);
        let residual = norm(&beside(&now.force, sought.mode, sought.kind));
        let rough = newton.wanted(now.scale, now.scale).max(ROUGH * now.scale);
        if residual <= rough || !residual.is_finite() {
            break;
        }
        let pin = factor_pinned(problem, workspace, &at, sought.pin.unknown)?;
        let again = Sought { pin: &pin, ..*sought };
        state = again.step(problem, workspace, &state, &now, None)?;
    }
    Ok(state)
}
