//! How soft a state is, which tells a body that floats, or that is about to
//! give way, from one that Newton's method fails on.
//!
//! The smallest eigenvalue λ of the Hessian by inverse iteration,
//! x ← H⁻¹x / |H⁻¹x|, λ ≈ 1 / (x · H⁻¹x), from above; and the compliance f · H⁻¹f
//! to the loads, with f = −∂²E/∂u∂t the force that a unit of the load parameter
//! adds. It grows without bound towards a limit point.
//!
//! Source: Golub and Van Loan, "Matrix Computations", section 8.2.

use mesh::Vec3;

use super::System;
use crate::energy::Hessian;
use crate::math::linear::{Pivot, Precision, dot, norm};
use crate::math::random::Random;

/// Inverse iterations; the error of λ falls by (λ/λ₂)² in each.
const ITERATIONS: usize = 8;
/// Added to a Hessian that cannot be factored, relative to its diagonal.
const SHIFT: f64 = 1e-9;
/// Below this fraction of the largest diagonal entry a motion has no stiffness:
/// rounding leaves 1e-16, and a slender beam has 1e-9.
const NONE: f64 = 1e-11;

/// How soft a state is.
#[derive(Clone, Debug)]
pub struct Softness {
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

impl Softness {
    /// Whether something moves without any force.
    #[must_use]
    pub fn floats(&self) -> bool {
        self.stiffness.is_some_and(|stiffness| stiffness < NONE * self.largest)
    }

    /// Of a state at the first of two loads; forces are those that the step to
    /// the second adds.
    pub fn of(system: &mut System, rest: &[Vec3], u: &[f64], [load, next]: [f64; 2]) -> Self {
        let mut hessian = system.hessian(rest, u, load, Hessian::Exact);
        let entries = system.diagonal().iter().map(|&d| hessian.lower[d]);
        let largest = entries.fold(0.0_f64, |m, d| m.max(d.abs()));
        let motion = vec![0.0; u.len()];
        let nothing = Self { stiffness: None, compliance: None, motion, pivot: None, largest };
        let (mut shift, mut pivot, mut compliance) = (0.0, None, None);
        if system.linear.factor_positive(hessian.clone(), Precision::Double).is_ok() {
            pivot = system.linear.smallest_pivot();
            compliance = compliance_of(system, rest, u, [load, next]);
        } else {
            shift = SHIFT * largest;
            system.diagonal().iter().for_each(|&d| hessian.lower[d] += shift);
            if system.linear.factor_positive(hessian, Precision::Double).is_err() {
                return nothing;
            }
        }
        let mut x = Random::new(1).numbers(system.linear.size());
        let mut eigenvalue = 0.0;
        for _ in 0..ITERATIONS {
            let length = norm(&x);
            x.iter_mut().for_each(|x| *x /= length);
            let mut y = x.clone();
            system.linear.solve(&mut y);
            eigenvalue = 1.0 / dot(&x, &y);
            x = y;
        }
        let length = norm(&x);
        x.iter_mut().for_each(|x| *x /= length);
        let stiffness = Some((eigenvalue - shift).max(0.0)).filter(|_| eigenvalue > 0.0);
        Self { stiffness, compliance, motion: system.prolong(&x), pivot, largest }
    }
}

fn compliance_of(
    system: &mut System,
    rest: &[Vec3],
    u: &[f64],
    [load, next]: [f64; 2],
) -> Option<f64> {
    let (before, _) = system.gradient(rest, u, load);
    let (after, _) = system.gradient(rest, u, next);
    let added: Vec<f64> = before.iter().zip(&after).map(|(b, a)| (b - a) / (next - load)).collect();
    let force = system.restrict(&added);
    let mut response = force.clone();
    system.linear.solve(&mut response);
    Some(dot(&force, &response)).filter(|c| *c > 0.0)
}
