//! Nonlinear least squares by the method of Levenberg and Marquardt.
//!
//! min ½|r(x)|²: (JᵀJ + λ diag JᵀJ) Δx = −Jᵀr, with λ lowered after a step that
//! helps and raised after one that does not.
//!
//! Source: Marquardt 1963, doi:10.1137/0111030. Own code: the published crate
//! needs a second nalgebra, and dense problems of six unknowns need no more.

use nalgebra::{DMatrix, DVector};

/// Residuals r(x) and Jacobian ∂r/∂x.
pub type Residuals = (DVector<f64>, DMatrix<f64>);

/// Where the iteration ended.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// x.
    pub x: Vec<f64>,
    /// |r|².
    pub sum: f64,
}

/// Minimises |r|² from `start`; `residuals` gives nothing where x is not
/// admissible, which a step then never enters.
///
/// Gives nothing when `start` is not admissible.
pub fn levenberg_marquardt(
    start: &[f64],
    residuals: impl Fn(&[f64]) -> Option<Residuals>,
) -> Option<Minimum> {
    const ITERATIONS: usize = 500;
    let mut x = DVector::from_column_slice(start);
    let (mut r, mut jacobian) = residuals(x.as_slice())?;
    let mut damping = 1e-3;
    for _ in 0..ITERATIONS {
        let gradient = jacobian.transpose() * &r;
        let mut normal = jacobian.transpose() * &jacobian;
        for i in 0..x.len() {
            // a column of zeros must not make the matrix singular
            normal[(i, i)] += damping * normal[(i, i)].max(f64::MIN_POSITIVE.sqrt());
        }
        let step = normal.cholesky().map(|factor| factor.solve(&-gradient));
        let moved = step.as_ref().is_none_or(|s| s.norm() > 1e-12 * x.norm());
        let trial = step.map(|step| &x + step);
        let better = trial.and_then(|trial| {
            let new = residuals(trial.as_slice())?;
            (new.0.norm() < r.norm()).then_some((trial, new))
        });
        if let Some(better) = better {
            (x, (r, jacobian)) = better;
            damping = (damping * 0.2).max(1e-15);
        } else {
            damping *= 4.0;
        }
        if !moved || damping > 1e15 {
            break;
        }
    }
    Some(Minimum { x: x.as_slice().to_vec(), sum: r.norm_squared() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rosenbrock_is_solved() {
        let problem = |x: &[f64]| {
            let r = DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
            Some((r, DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0])))
        };
        let minimum = levenberg_marquardt(&[-1.2, 1.0], problem).expect("admissible");
        assert!((minimum.x[0] - 1.0).abs() < 1e-9 && (minimum.x[1] - 1.0).abs() < 1e-9);
        assert!(minimum.sum < 1e-18);
    }

    #[test]
    fn no_step_leaves_what_is_admissible() {
        // the minimum of (x + 1)² over x > 0 is at the border
        let problem = |x: &[f64]| {
            let r = DVector::from_element(1, x[0] + 1.0);
            (x[0] > 0.0).then(|| (r, DMatrix::from_element(1, 1, 1.0)))
        };
        let minimum = levenberg_marquardt(&[2.0], problem).expect("admissible");
        assert!(minimum.x[0] > 0.0 && minimum.x[0] < 1e-6, "{minimum:?}");
        assert!(levenberg_marquardt(&[-1.0], problem).is_none());
    }
}
