//! Preconditioned conjugate gradients, which tell whether a matrix is positive definite.
//!
//! Source: Nocedal and Wright, "Numerical Optimization", algorithm 5.3 and, for negative
//! curvature, section 7.1.

use super::matrix::add_scaled;
use super::{dot, norm};

/// Steps without progress after which a solution has come to rounding.
const STALLED_STEPS: usize = 3;

/// Solves A x = b from zero, with `multiply` for A and `precondition` for an approximate
/// inverse.
pub fn conjugate_gradients(
    multiply: impl Fn(&[f64]) -> Vec<f64>,
    precondition: impl Fn(&[f64]) -> Vec<f64>,
    b: &[f64],
    stop: &Stop,
) -> Gradients {
    let size = norm(b).max(f64::MIN_POSITIVE);
    let mut x = vec![0.0; b.len()];
    let mut r = b.to_vec();
    let mut p = precondition(&r);
    let mut rz = dot(&r, &p);
    // where a matrix proves not positive definite at once, a descent
    let mut best = (p.clone(), if norm(b) > 0.0 { f64::INFINITY } else { 0.0 });
    let (mut since, mut curved) = (0, false);
    for step in 1..=stop.steps {
        let ap = multiply(&p);
        let curvature = dot(&p, &ap);
        if curvature.is_nan() || curvature <= 0.0 {
            curved = true;
            break;
        }
        let alpha = rz / curvature;
        add_scaled(&mut x, alpha, &p);
        add_scaled(&mut r, -alpha, &ap);
        let residual = norm(&r) / size;
        since += 1;
        if residual < best.1 {
            best = (x.clone(), residual);
            since = 0;
        }
        if best.1 <= stop.tolerance || since >= STALLED_STEPS || stop.is_hopeless(step, best.1) {
            break;
        }
        let mut z = precondition(&r);
        let next = dot(&r, &z);
        let beta = next / rz;
        // z + beta p
        add_scaled(&mut z, beta, &p);
        p = z;
        rz = next;
    }
    Gradients { x: best.0, residual: best.1, curved }
}

/// Where conjugate gradients end.
pub struct Gradients {
    /// The best x.
    pub x: Vec<f64>,
    /// The relative residual.
    pub residual: f64,
    /// Whether they met a direction of negative curvature.
    curved: bool,
}

impl Gradients {
    /// What they say of the matrix, where a relative residual is wanted.
    pub fn outcome(self, tolerance: f64) -> Outcome {
        if self.curved {
            Outcome::Curved
        } else if self.residual <= tolerance {
            Outcome::Solved(self.x)
        } else {
            Outcome::Inaccurate
        }
    }
}

/// What conjugate gradients find.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The solution.
    Solved(Vec<f64>),
    /// A direction p with pᵀ A p ≤ 0: A is not positive definite.
    Curved,
    /// Neither was found within the precision of the factor.
    Inaccurate,
}

impl Outcome {
    /// The solution, if it was found.
    pub fn solved(self) -> Option<Vec<f64>> {
        if let Self::Solved(x) = self { Some(x) } else { None }
    }
}

/// When conjugate gradients end.
pub struct Stop {
    /// Relative residual wanted.
    pub tolerance: f64,
    /// Steps at most.
    pub steps: usize,
    /// Whether to give up when the tolerance is out of reach.
    pub near: bool,
}

impl Stop {
    /// Whether a residual reached in `step` steps will not come to the
    /// tolerance at this rate.
    fn is_hopeless(&self, step: usize, residual: f64) -> bool {
        let rate = residual.powf(1.0 / step as f64);
        self.near && step >= 3 && rate.powi(self.steps as i32) > self.tolerance
    }
}
