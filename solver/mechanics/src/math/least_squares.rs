//! Nonlinear least squares by the method of Levenberg and Marquardt.
//!
//! min |r(x)|²: (JᵀJ + λ diag JᵀJ) Δx = −Jᵀr, with λ lowered after a step that
//! helps and raised after one that does not.
//!
//! Source: Marquardt 1963, doi:10.1137/0111030. Own code: the published crate
//! needs a second nalgebra, and dense problems of six unknowns need no more.

use std::convert::Infallible;

use nalgebra::{DMatrix, DVector};

/// λ of the first step, and the smallest.
const DAMPING: [f64; 2] = [1e-3, 1e-15];
/// Factors of λ after a step that helps, and after one that does not.
const LOWER: f64 = 0.1;
const HIGHER: f64 = 10.0;

/// Residuals r(x) and their Jacobian ∂r/∂x.
#[derive(Clone, Debug)]
pub struct Residuals {
    /// r.
    pub r: DVector<f64>,
    /// ∂r/∂x.
    pub jacobian: DMatrix<f64>,
}

impl Residuals {
    /// |r|².
    pub fn sum(&self) -> f64 {
        self.r.norm_squared()
    }

    /// JᵀJ.
    pub fn normal(&self) -> DMatrix<f64> {
        self.jacobian.tr_mul(&self.jacobian)
    }

    /// Δx; none where the damped matrix is singular.
    fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let mut normal = self.normal();
        for i in 0..normal.nrows() {
            // a column of zeros must not make the matrix singular
            normal[(i, i)] += damping * normal[(i, i)].max(f64::MIN_POSITIVE.sqrt());
        }
        Some(-normal.cholesky()?.solve(&self.jacobian.tr_mul(&self.r)))
    }
}

/// Where an iteration is.
#[derive(Clone, Debug)]
pub struct LevenbergMarquardt {
    /// x.
    pub x: Vec<f64>,
    /// There.
    pub residuals: Residuals,
    /// λ of the next step.
    pub damping: f64,
}

/// What came of a step that was tried.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// |Δx| / |x|; infinite where there was no step.
    pub length: f64,
    /// Whether |r|² is smaller there, so that the iteration went there.
    pub helped: bool,
}

impl LevenbergMarquardt {
    /// Begins at x, with the residuals there.
    pub fn new(x: &[f64], residuals: Residuals) -> Self {
        Self { x: x.to_vec(), residuals, damping: DAMPING[0] }
    }

    /// Tries a step. `model` has no residuals where x is not admissible, where no step goes.
    pub fn advance<E>(
        &mut self,
        model: impl FnOnce(&[f64]) -> Result<Option<Residuals>, E>,
    ) -> Result<Trial, E> {
        let Some(step) = self.residuals.step(self.damping) else {
            self.damping *= HIGHER;
            return Ok(Trial { length: f64::INFINITY, helped: false });
        };
        let size = self.x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let x: Vec<f64> = self.x.iter().zip(step.iter()).map(|(x, d)| x + d).collect();
        let there = model(&x)?.filter(|there| there.sum() < self.residuals.sum());
        let helped = there.is_some();
        if let Some(residuals) = there {
            (self.x, self.residuals) = (x, residuals);
            self.damping = (self.damping * LOWER).max(DAMPING[1]);
        } else {
            self.damping *= HIGHER;
        }
        Ok(Trial { length: step.norm() / size, helped })
    }
}

/// Where the iteration ended.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// x.
    pub x: Vec<f64>,
    /// |r|².
    pub sum: f64,
}

/// Minimises |r|² from `start` to rounding; `residuals` gives nothing where x is not
/// admissible, which a step then never enters.
///
/// Gives nothing when `start` is not admissible.
pub fn levenberg_marquardt(
    start: &[f64],
    residuals: impl Fn(&[f64]) -> Option<Residuals>,
) -> Option<Minimum> {
    const ITERATIONS: usize = 500;
    let mut iteration = LevenbergMarquardt::new(start, residuals(start)?);
    for _ in 0..ITERATIONS {
        let Ok(trial) = iteration.advance(|x| Ok::<_, Infallible>(residuals(x)));
        if trial.length <= 1e-12 || iteration.damping > 1e15 {
            break;
        }
    }
    Some(Minimum { sum: iteration.residuals.sum(), x: iteration.x })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rosenbrock_is_solved() {
        let problem = |x: &[f64]| {
            let r = DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
            let jacobian = DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]);
            Some(Residuals { r, jacobian })
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
            (x[0] > 0.0).then(|| Residuals { r, jacobian: DMatrix::from_element(1, 1, 1.0) })
        };
        let minimum = levenberg_marquardt(&[2.0], problem).expect("admissible");
        assert!(minimum.x[0] > 0.0 && minimum.x[0] < 1e-6, "{minimum:?}");
        assert!(levenberg_marquardt(&[-1.0], problem).is_none());
    }
}
