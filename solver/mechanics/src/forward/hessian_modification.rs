//! Hessian modification: descent directions −H̃⁻¹g of Newton's method. H̃ is the exact
//! Hessian if it is positive definite, which conjugate gradients decide where a few pivots
//! in single precision are not positive. Where it is not, H̃ is made of parts that are
//! positive semidefinite: elastic tangents and contacts are projected, and the stiffness of
//! pressures on turning walls is left out. Where rounding makes even that indefinite, a
//! multiple of the identity is added (a shift).
//!
//! What was measured (beam P2 at 50 kPa, gripper P1 at 60 kPa, frog P2 at 55 kPa,
//! from rest; Newton iterations / factorisations), with the stiffness of pressures kept:
//! points projected 13/9, 35/32, 22/15; whole elements projected 15/10, 37/33, 22/15;
//! projected and shifted at once 15/8, 36/33; the exact Hessian shifted 16/10, 43/63. No
//! run left the last modification without a step, so there is no gradient descent below it.
//! Without that stiffness no shift is needed (frog 15/14 before, 13/13 then). Tried in
//! vain: principal submatrices of the exact Hessian on each element, in double precision;
//! the worm's Hessian is indefinite six times, and on no element.

use super::{Clock, Problem, Workspace};
use crate::energy::{Hessian, Iterate};
use crate::math::linear::{Factorization, Outcome, Precision, Symmetric, dot};

/// Relative residual that a direction by an indefinite factor may have.
const ACCURATE: f64 = 1e-6;

/// The matrix that a direction is computed with, from the least to the most modified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Modification {
    /// The exact Hessian, solved by conjugate gradients with an earlier factor.
    Near,
    /// The exact Hessian, factored.
    Exact,
    /// Elastic tangents and contacts projected, by conjugate gradients with an earlier
    /// factor or factored.
    Projected,
    /// The projected Hessian with a multiple of the identity added.
    Shifted,
}

impl Modification {
    /// The next one, if any.
    pub fn next(self) -> Option<Self> {
        match self {
            Self::Near => Some(Self::Exact),
            Self::Exact => Some(Self::Projected),
            Self::Projected => Some(Self::Shifted),
            Self::Shifted => None,
        }
    }
}

/// One iterate and its gradient.
#[derive(Clone, Copy)]
pub struct Point<'a> {
    /// The iterate.
    pub at: Iterate<'a>,
    /// Gradient over all degrees of freedom [N].
    pub gradient: &'a [f64],
}

/// The first direction that `from` or a later modification gives, and which.
/// None where the Hessian is not finite.
pub fn direction(
    problem: &Problem,
    workspace: &mut Workspace,
    point: &Point,
    from: Modification,
    forcing: f64,
) -> Option<(Modification, Vec<f64>)> {
    let mut force = problem.restrict(point.gradient);
    force.iter_mut().for_each(|d| *d = -*d);
    let at = &point.at;
    let has_factor = workspace.linear().last().is_some_and(Factorization::is_positive);
    let blind = from == Modification::Near && !has_factor;
    let found = if blind && is_under_pressure(problem, at) {
        first(problem, workspace, at, &force, forcing)
    } else if from <= Modification::Exact {
        exact(problem, workspace, at, &force, from, forcing)
    } else {
        None
    };
    let (modification, free) = match found {
        Some(found) => found,
        None => projected(problem, workspace, at, force, from, forcing)?,
    };
    Some((modification, problem.prolong(&free)))
}

/// Whether a chamber has a pressure, which softens some motions of its wall.
fn is_under_pressure(problem: &Problem, at: &Iterate) -> bool {
    problem.energies.chambers().any(|(_, chamber)| chamber.state(at).1.pressure != 0.0)
}

/// The first direction of a body under pressure, whose exact Hessian is likely to be indefinite: the projected one is
/// factored, and conjugate gradients with that factor decide whether the exact one serves.
fn first(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    force: &[f64],
    forcing: f64,
) -> Option<(Modification, Vec<f64>)> {
    let matrix = workspace.hessian(problem, at, Hessian::Projected);
    if !factor(workspace, matrix) {
        return None;
    }
    let hessian = workspace.hessian(problem, at, Hessian::Exact);
    let exact = near(workspace, &hessian, force, forcing).solved();
    workspace.recycle(hessian);
    if let Some(direction) = exact {
        return Some((Modification::Near, direction));
    }
    Some((Modification::Projected, solve(workspace, force.to_vec(), forcing)?))
}

fn projected(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    force: Vec<f64>,
    from: Modification,
    forcing: f64,
) -> Option<(Modification, Vec<f64>)> {
    let matrix = workspace.hessian(problem, at, Hessian::Projected);
    if from < Modification::Shifted
        && let Some(direction) = near(workspace, &matrix, &force, forcing).solved()
    {
        workspace.recycle(matrix);
        return Some((Modification::Projected, direction));
    }
    if from < Modification::Shifted && factor(workspace, matrix.clone()) {
        return Some((Modification::Projected, solve(workspace, force, forcing)?));
    }
    if !factor_shifted(workspace, &matrix) {
        return None;
    }
    Some((Modification::Shifted, solve(workspace, force, forcing)?))
}

fn exact(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    force: &[f64],
    from: Modification,
    forcing: f64,
) -> Option<(Modification, Vec<f64>)> {
    let hessian = workspace.hessian(problem, at, Hessian::Exact);
    if from == Modification::Near {
        match near(workspace, &hessian, force, forcing) {
            Outcome::Solved(direction) => {
                workspace.recycle(hessian);
                return Some((Modification::Near, direction));
            }
            // known to be indefinite, without a factorisation
            Outcome::Curved if hessian.updates.is_empty() => {
                workspace.recycle(hessian);
                return None;
            }
            Outcome::Curved | Outcome::Inaccurate => {}
        }
    }
    // where gas stiffens the body, the whole may be positive definite although
    // its sparse part is not
    let stiffened = hessian.updates.iter().any(|u| u.0 > 0.0).then(|| hessian.clone());
    match factor_and_solve(workspace, hessian, force, forcing)? {
        Outcome::Solved(direction) => Some((Modification::Exact, direction)),
        Outcome::Curved => None,
        Outcome::Inaccurate if refactor_double(workspace) => {
            Some((Modification::Exact, solve(workspace, force.to_vec(), forcing)?))
        }
        Outcome::Inaccurate => {
            let direction = indefinite(workspace, stiffened?, force)?;
            Some((Modification::Exact, direction))
        }
    }
}

/// Conjugate gradients with an earlier factor.
fn near(workspace: &mut Workspace, matrix: &Symmetric, force: &[f64], forcing: f64) -> Outcome {
    let clock = Clock::start();
    let last = workspace.linear().last();
    let outcome = last.map_or(Outcome::Inaccurate, |f| f.solve_near(matrix, force, forcing));
    workspace.timings.solve += clock.elapsed();
    outcome
}

/// Factors a Hessian, of which a few pivots need not be positive, and solves with it.
fn factor_and_solve(
    workspace: &mut Workspace,
    hessian: Symmetric,
    force: &[f64],
    forcing: f64,
) -> Option<Outcome> {
    let factored =
        workspace.factor(|linear| linear.factor_modified(hessian).map(|(_, replaced)| replaced));
    workspace.timings.factorizations += 1;
    let replaced = match factored {
        Ok(replaced) => replaced,
        Err(error) => {
            workspace.timings.failed_factorizations += 1;
            log::debug!("{error}");
            return None;
        }
    };
    let clock = Clock::start();
    let found = workspace.linear().last()?.solve_modified(force, forcing);
    workspace.timings.solve += clock.elapsed();
    if replaced > 0 {
        let end = match &found {
            Outcome::Solved(_) => "positive definite",
            Outcome::Curved => "indefinite",
            Outcome::Inaccurate => "undecided",
        };
        log::debug!("{replaced} pivots replaced: {end}");
    }
    Some(found)
}

/// Factors the last matrix again in double precision; false where that is not positive
/// definite.
fn refactor_double(workspace: &mut Workspace) -> bool {
    let positive =
        workspace.factor(|linear| linear.refactor_double().is_some_and(Factorization::is_positive));
    workspace.timings.factorizations += 1;
    positive
}

/// H⁻¹f by an indefinite factor, if it is accurate and descends.
fn indefinite(workspace: &mut Workspace, whole: Symmetric, force: &[f64]) -> Option<Vec<f64>> {
    workspace.factor(|linear| linear.factor_indefinite(whole).is_positive());
    workspace.timings.factorizations += 1;
    let clock = Clock::start();
    let mut direction = force.to_vec();
    let residual = workspace.linear().last()?.solve(&mut direction);
    workspace.timings.solve += clock.elapsed();
    (residual < ACCURATE && dot(force, &direction) > 0.0).then_some(direction)
}

/// A⁻¹f by the last factorisation, if there is one.
fn solve(workspace: &mut Workspace, mut force: Vec<f64>, forcing: f64) -> Option<Vec<f64>> {
    let clock = Clock::start();
    workspace.linear().last()?.solve_to(&mut force, forcing);
    workspace.timings.solve += clock.elapsed();
    Some(force)
}

fn factor(workspace: &mut Workspace, matrix: Symmetric) -> bool {
    let result =
        workspace.factor(|linear| linear.factor_positive(matrix, Precision::Single).map(drop));
    workspace.timings.factorizations += 1;
    if let Err(error) = &result {
        workspace.timings.failed_factorizations += 1;
        log::debug!("{error}");
    }
    result.is_ok()
}

/// Adds ρ I, with ρ upwards by powers of ten, until the matrix is positive
/// definite, which ρ beyond its eigenvalues makes it if it is finite. Each
/// attempt costs a factorisation, so the first ρ is not small: the frog under
/// pressure needed 1e-5 of the largest diagonal entry, the gripper 1e-3.
fn factor_shifted(workspace: &mut Workspace, matrix: &Symmetric) -> bool {
    let largest = workspace.diagonal().iter().map(|&d| matrix.lower[d].abs()).fold(0.0, f64::max);
    let mut shift = 1e-5 * largest;
    while shift.is_finite() && shift > 0.0 {
        let mut shifted = matrix.clone();
        for &d in workspace.diagonal() {
            shifted.lower[d] += shift;
        }
        if factor(workspace, shifted) {
            log::debug!("shifted by {:.0e} of the largest diagonal entry", shift / largest);
            return true;
        }
        shift *= 10.0;
    }
    false
}
