//! The softest mode of a state: it shows whether a body can move as a rigid body, is
//! about to lose its stability (buckling, ballooning), or whether only Newton's method
//! fails.
//!
//! The smallest eigenvalue λ of the Hessian by inverse iteration,
//! x ← H⁻¹x / |H⁻¹x|, λ ≈ 1 / (x · H⁻¹x), from above; and the compliance f · H⁻¹f
//! to the loads, with f = −∂²E/∂u∂t the force that a unit of the load parameter
//! adds. It grows without bound towards a limit point.
//!
//! Source: Golub and Van Loan, "Matrix Computations", section 8.2.

use crate::energy::{Hessian, Iterate};
use crate::forward::{Problem, Workspace};
use crate::math::linear::{Factorization, Pivot, Precision, dot, norm};
use crate::math::random::Random;

/// Inverse iterations; the error of λ falls by (λ/λ₂)² in each.
const ITERATIONS: usize = 8;
/// Added to a Hessian that cannot be factored, relative to its diagonal.
const SHIFT: f64 = 1e-9;
/// Below this fraction of the largest diagonal entry a motion has no stiffness:
/// rounding leaves 1e-16, and a slender beam has 1e-9.
const NONE: f64 = 1e-11;

/// The softest mode of a state, and its compliance to the loads.
#[derive(Clone, Debug)]
pub struct SoftestMode {
    /// Smallest eigenvalue of the Hessian [N/m]; none if some are negative.
    pub stiffness: Option<f64>,
    /// Compliance to the loads [J]; none if the Hessian has no Cholesky factor or
    /// the loads do not act by forces.
    pub compliance: Option<f64>,
    /// The softest motion over all degrees of freedom, of length 1.
    pub motion: Vec<f64>,
    /// Smallest pivot of the factored Hessian; none if it has no Cholesky factor.
    pub pivot: Option<Pivot>,
    /// Largest diagonal entry of the Hessian [N/m].
    pub largest: f64,
}

impl SoftestMode {
    /// Whether something moves without any force, in a body whose bulk modulus is so many times its
    /// shear modulus: the largest entry is of the first, motions are resisted by the second.
    pub fn floats(&self, bulk_over_shear: f64) -> bool {
        let none = NONE / bulk_over_shear.max(1.0);
        self.stiffness.is_some_and(|stiffness| stiffness < none * self.largest)
    }

    /// The softest mode of a state; forces are those that the step to the load `next` adds.
    pub fn of(problem: &Problem, workspace: &mut Workspace, at: &Iterate, next: f64) -> Self {
        let mut hessian = workspace.hessian(problem, at, Hessian::Exact);
        let entries = workspace.diagonal().iter().map(|&d| hessian.lower[d]);
        let largest = entries.fold(0.0_f64, |m, d| m.max(d.abs()));
        let motion = vec![0.0; at.u.len()];
        let nothing = Self { stiffness: None, compliance: None, motion, pivot: None, largest };
        let (mut shift, mut pivot, mut compliance) = (0.0, None, None);
        let exact = workspace.factor(|linear| {
            let factored = linear.factor_positive(hessian.clone(), Precision::Double);
            factored.map(Factorization::smallest_pivot)
        });
        if let Ok(smallest) = exact {
            pivot = smallest;
            compliance = compliance_of(problem, workspace, at, next);
        } else {
            shift = SHIFT * largest;
            workspace.diagonal().iter().for_each(|&d| hessian.lower[d] += shift);
            let factored = workspace
                .factor(|linear| linear.factor_positive(hessian, Precision::Double).map(drop));
            if factored.is_err() {
                return nothing;
            }
        }
        let Some(factored) = workspace.linear().last() else { return nothing };
        let mut x = Random::new(1).numbers(workspace.linear().size());
        let mut eigenvalue = 0.0;
        for _ in 0..ITERATIONS {
            let length = norm(&x);
            x.iter_mut().for_each(|x| *x /= length);
            let mut y = x.clone();
            factored.solve(&mut y);
            eigenvalue = 1.0 / dot(&x, &y);
            x = y;
        }
        let length = norm(&x);
        x.iter_mut().for_each(|x| *x /= length);
        let stiffness = Some((eigenvalue - shift).max(0.0)).filter(|_| eigenvalue > 0.0);
        Self { stiffness, compliance, motion: problem.prolong(&x), pivot, largest }
    }
}

fn compliance_of(
    problem: &Problem,
    workspace: &mut Workspace,
    at: &Iterate,
    next: f64,
) -> Option<f64> {
    let (before, _) = workspace.gradient(problem, at);
    let (after, _) = workspace.gradient(problem, &Iterate { time: next, ..*at });
    let slope = |(b, a): (&f64, &f64)| (b - a) / (next - at.time);
    let added: Vec<f64> = before.iter().zip(&after).map(slope).collect();
    let force = problem.restrict(&added);
    let mut response = force.clone();
    workspace.linear().last()?.solve(&mut response);
    Some(dot(&force, &response)).filter(|c| *c > 0.0)
}
