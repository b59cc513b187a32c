//! How far an equilibrium is from losing its stability.
//!
//! An equilibrium at a held load is stable if the exact Hessian H is positive definite on the motions that leave the
//! prescribed volumes alone. The number of negative eigenvalues there follows from the inertia of the factor,
//!
//! neg = neg(H) + pos(Gᵀ H⁻¹ G) − m,   G = ∂V/∂u of m volumes
//!
//! and the eigenvalue next to zero with its mode φ from the inverse by the method of Lanczos. Where it vanishes, the direction of the
//! path du/dt either is φ (a limit point: the load turns) or has no share of it (a bifurcation: another branch leaves).
//!
//! Source: Wriggers and Simo 1990, "A general procedure for the direct computation of turning and bifurcation points",
//! doi:10.1002/nme.1620300110; Golub and Van Loan, "Matrix Computations", sections 8.1 and 8.2.

use super::bordered::Bordered;
use super::tangent_system::{LoadRate, Row, at_held_load, factor, path_direction};
use crate::energy::Iterate;
use crate::forward::{Problem, Singularity, Stability, Workspace};
use crate::math::lanczos::largest;
use crate::math::linear::{Factorization, dot, norm};
use crate::math::random::Random;

/// Relative residual of the softest mode: its square is that of its stiffness.
const SETTLED: f64 = 1e-7;
/// Part of the path's direction along the softest mode that makes it that of a limit point.
const ALONG: f64 = 0.5;

impl Stability {
    /// The stability of an equilibrium; none where the tangent is singular.
    pub fn of(problem: &Problem, workspace: &mut Workspace, at: &Iterate) -> Option<Self> {
        let constraints = problem.constraints(at);
        let rate = LoadRate::of(problem, workspace, at);
        let factor = factor(problem, workspace, at)?;
        let row = Row { u: vec![0.0; rate.force.len()], load: 1.0 };
        let (direction, _) = path_direction(problem, factor, &constraints, &rate, row)?;
        let held = at_held_load(problem, factor, &constraints);
        Self::with(problem, factor, &held, &direction)
    }

    /// The stability by the factor of the exact Hessian, where the path goes along a direction.
    pub(super) fn with(
        problem: &Problem,
        factor: &Factorization,
        held: &Bordered,
        direction: &[f64],
    ) -> Option<Self> {
        let (stiffness, mode) = softest(factor, held)?;
        let length = norm(direction);
        let along = if length > 0.0 { dot(&mode, direction).abs() / length } else { 0.0 };
        Some(Self {
            negative: negative_eigenvalues(factor, held),
            stiffness,
            mode: problem.prolong(&mode),
            along_path: along,
        })
    }

    /// What happens where the stiffness of the mode vanishes.
    pub fn kind(&self) -> Singularity {
        if self.along_path >= ALONG { Singularity::LimitPoint } else { Singularity::Bifurcation }
    }
}

/// Negative eigenvalues of the factored Hessian on the motions that leave the prescribed volumes alone.
pub(super) fn negative_eigenvalues(factor: &Factorization, held: &Bordered) -> usize {
    let all = factor.negative_eigenvalues() + held.negative_eigenvalues();
    all.saturating_sub(held.count())
}

/// The eigenvalue nearest to zero [N/m] and its mode on the free degrees of freedom.
pub(super) fn softest(factor: &Factorization, held: &Bordered) -> Option<(f64, Vec<f64>)> {
    let zero = vec![0.0; held.count()];
    let start = Random::new(1).numbers(factor.size());
    let inverse = |x: &[f64]| held.solve(factor, x, &zero).map(|(y, _)| y);
    let (by_inverse, mode) = largest(start, SETTLED, inverse)?;
    let eigenvalue = 1.0 / by_inverse;
    eigenvalue.is_finite().then_some((eigenvalue, mode))
}
