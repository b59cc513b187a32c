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
use crate::math::linear::{Factorization, NotPositive, Outcome, Precision, Symmetric, dot};

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
/// None where the Hessian is not finite. Where it is doubtful whether the exact Hessian of a body under pressure is
/// positive definite, it is not factored to find out.
pub fn direction(
    problem: &Problem,
    workspace: &mut Workspace,
    point: &Point,
    from: Modification,
    is_doubtful: bool,
    forcing: f64,
) -> Option<(Modification, Vec<f64>)> {
    let mut force = problem.restrict(point.gradient);
    force.iter_mut().for_each(|d| *d = -*d);
    let mut system = System { problem, workspace, at: point.at, force, from, is_doubtful, forcing };
    let (modification, free) = system.direction()?;
    Some((modification, problem.prolong(&free)))
}

/// H̃ δ = f, with f = −g.
struct System<'a> {
    problem: &'a Problem,
    workspace: &'a mut Workspace,
    at: Iterate<'a>,
    /// f on the unknowns [N].
    force: Vec<f64>,
    from: Modification,
    is_doubtful: bool,
    /// Relative residual that is allowed.
    forcing: f64,
}

impl System<'_> {
    fn direction(&mut self) -> Option<(Modification, Vec<f64>)> {
        let is_doubtful = self.from == Modification::Near && self.is_doubtful;
        let found = if is_doubtful && self.is_under_pressure() {
            self.probed()
        } else if self.from <= Modification::Exact {
            self.exact()
        } else {
            None
        };
        found.or_else(|| self.projected())
    }

    /// Whether a chamber has a pressure, which softens some motions of its wall.
    fn is_under_pressure(&self) -> bool {
        let mut chambers = self.problem.energies.chambers();
        chambers.any(|(_, chamber)| chamber.state(&self.at).1.pressure != 0.0)
    }

    /// The direction where the exact Hessian may well be indefinite: conjugate gradients with the last factor decide whether
    /// it serves, or else with that of the projected one.
    fn probed(&mut self) -> Option<(Modification, Vec<f64>)> {
        if self.workspace.linear().last().is_some() {
            match self.near_exact() {
                (Outcome::Solved(direction), _) => return Some((Modification::Near, direction)),
                (Outcome::Curved, true) => return None,
                (Outcome::Curved | Outcome::Inaccurate, _) => {}
            }
        }
        // made again afterwards, so that no more memory is taken
        let projected = self.workspace.hessian(self.problem, &self.at, Hessian::Projected);
        if !self.factor(projected) {
            return None;
        }
        if let (Outcome::Solved(direction), _) = self.near_exact() {
            return Some((Modification::Near, direction));
        }
        Some((Modification::Projected, self.solve()?))
    }

    /// Conjugate gradients for the exact Hessian with the last factor, and whether that is sparse.
    fn near_exact(&mut self) -> (Outcome, bool) {
        let hessian = self.workspace.hessian(self.problem, &self.at, Hessian::Exact);
        let outcome = self.near(&hessian);
        let is_sparse = hessian.updates.is_empty();
        self.workspace.recycle(hessian);
        (outcome, is_sparse)
    }

    fn projected(&mut self) -> Option<(Modification, Vec<f64>)> {
        let matrix = self.workspace.hessian(self.problem, &self.at, Hessian::Projected);
        if self.from < Modification::Shifted
            && let Some(direction) = self.near(&matrix).solved()
        {
            self.workspace.recycle(matrix);
            return Some((Modification::Projected, direction));
        }
        if self.from < Modification::Shifted && self.factor(matrix.clone()) {
            return Some((Modification::Projected, self.solve()?));
        }
        if !self.factor_shifted(&matrix) {
            return None;
        }
        Some((Modification::Shifted, self.solve()?))
    }

    fn exact(&mut self) -> Option<(Modification, Vec<f64>)> {
        let hessian = self.workspace.hessian(self.problem, &self.at, Hessian::Exact);
        if self.from == Modification::Near {
            match self.near(&hessian) {
                Outcome::Solved(direction) => {
                    self.workspace.recycle(hessian);
                    return Some((Modification::Near, direction));
                }
                // known to be indefinite, without a factorisation
                Outcome::Curved if hessian.updates.is_empty() => {
                    self.workspace.recycle(hessian);
                    return None;
                }
                Outcome::Curved | Outcome::Inaccurate => {}
            }
        }
        // where gas stiffens the body, the whole may be positive definite although
        // its sparse part is not
        let stiffened = hessian.updates.iter().any(|u| u.0 > 0.0).then(|| hessian.clone());
        let direction = match self.factor_and_solve(hessian)? {
            Outcome::Solved(direction) => direction,
            Outcome::Curved => return None,
            Outcome::Inaccurate if self.refactor_double() => self.solve()?,
            Outcome::Inaccurate => self.indefinite(stiffened?)?,
        };
        Some((Modification::Exact, direction))
    }

    /// Conjugate gradients with an earlier factor.
    fn near(&mut self, matrix: &Symmetric) -> Outcome {
        let clock = Clock::start();
        let solve = |f: &Factorization| f.solve_near(matrix, &self.force, self.forcing);
        let outcome = self.workspace.linear().last().map_or(Outcome::Inaccurate, solve);
        self.workspace.timings.solve += clock.elapsed();
        outcome
    }

    /// Factors a Hessian, of which a few pivots need not be positive, and solves with it.
    fn factor_and_solve(&mut self, hessian: Symmetric) -> Option<Outcome> {
        let factored = self
            .workspace
            .factor(|linear| linear.factor_modified(hessian).map(|(_, replaced)| replaced));
        let replaced = self.counted(factored)?;
        let clock = Clock::start();
        let found = self.workspace.linear().last()?.solve_modified(&self.force, self.forcing);
        self.workspace.timings.solve += clock.elapsed();
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
    fn refactor_double(&mut self) -> bool {
        self.workspace.timings.factorizations += 1;
        self.workspace
            .factor(|linear| linear.refactor_double().is_some_and(Factorization::is_positive))
    }

    /// H⁻¹f by an indefinite factor, if it is accurate and descends.
    fn indefinite(&mut self, whole: Symmetric) -> Option<Vec<f64>> {
        self.workspace.factor(|linear| linear.factor_indefinite(whole).is_positive());
        self.workspace.timings.factorizations += 1;
        let clock = Clock::start();
        let mut direction = self.force.clone();
        let residual = self.workspace.linear().last()?.solve(&mut direction);
        self.workspace.timings.solve += clock.elapsed();
        (residual < ACCURATE && dot(&self.force, &direction) > 0.0).then_some(direction)
    }

    /// A⁻¹f by the last factorisation, if there is one.
    fn solve(&mut self) -> Option<Vec<f64>> {
        let clock = Clock::start();
        let mut direction = self.force.clone();
        self.workspace.linear().last()?.solve_to(&mut direction, self.forcing);
        self.workspace.timings.solve += clock.elapsed();
        Some(direction)
    }

    fn factor(&mut self, matrix: Symmetric) -> bool {
        let factored = self
            .workspace
            .factor(|linear| linear.factor_positive(matrix, Precision::Single).map(drop));
        self.counted(factored).is_some()
    }

    /// What came of a factorisation, which is counted.
    fn counted<T>(&mut self, factored: Result<T, NotPositive>) -> Option<T> {
        let timings = &mut self.workspace.timings;
        timings.factorizations += 1;
        if let Err(error) = &factored {
            timings.failed_factorizations += 1;
            log::debug!("{error}");
        }
        factored.ok()
    }

    /// Adds ρ I, with ρ upwards by powers of ten, until the matrix is positive
    /// definite, which ρ beyond its eigenvalues makes it if it is finite. Each
    /// attempt costs a factorisation, so the first ρ is not small: the frog under
    /// pressure needed 1e-5 of the largest diagonal entry, the gripper 1e-3.
    fn factor_shifted(&mut self, matrix: &Symmetric) -> bool {
        let diagonal = self.workspace.diagonal().to_vec();
        let largest = diagonal.iter().map(|&d| matrix.lower[d].abs()).fold(0.0, f64::max);
        let mut shift = 1e-5 * largest;
        while shift.is_finite() && shift > 0.0 {
            let mut shifted = matrix.clone();
            diagonal.iter().for_each(|&d| shifted.lower[d] += shift);
            if self.factor(shifted) {
                log::debug!("shifted by {:.0e} of the largest diagonal entry", shift / largest);
                return true;
            }
            shift *= 10.0;
        }
        false
    }
}
