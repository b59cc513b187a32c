//! Weighted least squares by the Levenberg–Marquardt method.
//!
//! min χ²(p) = Σ_i r_i²,   r_i = (simulated_i(p) − measured_i) / σ_i
//! C = (JᵀJ)⁻¹ max(1, χ²/ν)
//!
//! σ_i   standard uncertainty of measurement i
//! C     covariance of the p; ν = measurements less numbers, and the factor counts scatter beyond
//!       the σ_i (Birge 1932, doi:10.1103/PhysRev.40.207)

use anyhow::Result;
use mechanics::math::least_squares::{LevenbergMarquardt, Residuals};
use nalgebra::{DMatrix, SymmetricEigen};

/// Iterations, at most.
const ITERATIONS: usize = 50;
/// A step is the last if it is this part of the standard errors of all numbers, or less.
const SETTLED_STEP: f64 = 1e-6;
/// A step of this part that lowers χ² no more is rounding of the simulations.
const SIMULATION_ROUNDING: f64 = 1e-3;
/// λ at which shorter steps are given up.
const LARGEST_DAMPING: f64 = 1e9;
/// Smallest eigenvalue of JᵀJ with a diagonal of ones at which numbers count as determined.
const DETERMINED: f64 = 1e-9;

/// Numbers at the minimum.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// p.
    pub numbers: Vec<f64>,
    /// There.
    pub residuals: Residuals,
    /// C.
    pub covariance: DMatrix<f64>,
    /// Steps that were taken.
    pub iterations: usize,
}

impl Minimum {
    /// With (JᵀJ)⁻¹ where the iteration ended.
    fn new(at: LevenbergMarquardt, inverse: DMatrix<f64>, iterations: usize) -> Self {
        let LevenbergMarquardt { x: numbers, residuals, .. } = at;
        let over = residuals.r.len().saturating_sub(numbers.len());
        let scatter = if over > 0 { (residuals.sum() / over as f64).max(1.0) } else { 1.0 };
        Self { numbers, residuals, covariance: inverse * scatter, iterations }
    }
}

/// Why there is no minimum.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// The model has no value at the start.
    #[error("the model cannot be evaluated at the start")]
    Start,
    /// Some combination of these numbers changes no residual.
    #[error("the measurements do not determine some of the numbers")]
    Undetermined(Vec<usize>),
    /// χ² still falls after the last iteration, or its derivatives do not belong to it.
    #[error("no minimum after {0} iterations")]
    Unsettled(usize),
}

/// The minimum from a start. `model` gives none where it cannot be evaluated, and `observe`
/// sees each iteration's numbers and residuals.
pub fn minimise(
    start: &[f64],
    mut model: impl FnMut(&[f64]) -> Result<Option<Residuals>>,
    mut observe: impl FnMut(usize, &[f64], &Residuals),
) -> Result<Result<Minimum, Failure>> {
    let Some(first) = model(start)? else { return Ok(Err(Failure::Start)) };
    let mut at = LevenbergMarquardt::new(start, first);
    for iterations in 0..=ITERATIONS {
        observe(iterations, &at.x, &at.residuals);
        let normal = at.residuals.normal();
        let free = undetermined(&normal);
        if !free.is_empty() {
            return Ok(Err(Failure::Undetermined(free)));
        }
        let inverse = normal.try_inverse().expect("regular, as its eigenvalues say");
        let whole = -(&inverse * at.residuals.jacobian.tr_mul(&at.residuals.r));
        let within =
            |part: f64| (0..whole.len()).all(|k| whole[k].abs() <= part * inverse[(k, k)].sqrt());
        if within(SETTLED_STEP) {
            return Ok(Ok(Minimum::new(at, inverse, iterations)));
        }
        while !at.advance(&mut model)?.helped {
            if within(SIMULATION_ROUNDING) {
                return Ok(Ok(Minimum::new(at, inverse, iterations)));
            }
            if at.damping > LARGEST_DAMPING {
                return Ok(Err(Failure::Unsettled(iterations)));
            }
        }
    }
    Ok(Err(Failure::Unsettled(ITERATIONS)))
}

/// The numbers of which some combination changes nothing.
fn undetermined(normal: &DMatrix<f64>) -> Vec<usize> {
    let n = normal.nrows();
    let without: Vec<usize> = (0..n).filter(|&k| normal[(k, k)] == 0.0).collect();
    if !without.is_empty() {
        return without;
    }
    let scaled =
        DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / (normal[(i, i)] * normal[(j, j)]).sqrt());
    let SymmetricEigen { eigenvalues, eigenvectors } = scaled.symmetric_eigen();
    let least = eigenvalues.imin();
    if eigenvalues[least] > DETERMINED {
        return Vec::new();
    }
    (0..n).filter(|&k| eigenvectors[(k, least)].abs() > 0.1).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    /// y = a exp(b x) at some x, with σ = 0.1.
    fn exponential(p: &[f64], y: &[f64]) -> Residuals {
        let x = |i: usize| 0.2 * i as f64;
        let of = |i: usize| (p[0] * (p[1] * x(i)).exp() - y[i]) / 0.1;
        let by = |i: usize, k: usize| {
            let e = (p[1] * x(i)).exp() / 0.1;
            if k == 0 { e } else { p[0] * x(i) * e }
        };
        let r = DVector::from_fn(y.len(), |i, _| of(i));
        Residuals { r, jacobian: DMatrix::from_fn(y.len(), 2, by) }
    }

    fn fit(y: &[f64]) -> Minimum {
        let model = |p: &[f64]| Ok((p[1] < 3.0).then(|| exponential(p, y)));
        minimise(&[1.0, 0.0], model, |_, _, _| ()).expect("a model").expect("a minimum")
    }

    #[test]
    fn a_known_curve_is_found_again() {
        let y: Vec<f64> = (0..8).map(|i| 2.5 * (-0.7 * 0.2 * f64::from(i)).exp()).collect();
        let found = fit(&y);
        assert!((found.numbers[0] - 2.5).abs() < 1e-7 && (found.numbers[1] + 0.7).abs() < 1e-7);
        assert!(found.residuals.sum() < 1e-10);
    }

    /// A mean of n values has the standard error σ/√n, and s/√n where they scatter by s > σ.
    #[test]
    fn standard_errors_are_those_of_a_mean() {
        for (spread, expected) in [(0.5, 1.0 / 3.0), (4.0, 4.0 * (9.0_f64 / 8.0).sqrt() / 3.0)] {
            // −1, 0, 1 times √(3/2): variance 1 about the mean
            let y = |i: usize| 7.0 + spread * 1.5_f64.sqrt() * ((i % 3) as f64 - 1.0);
            let model = |p: &[f64]| {
                let r = DVector::from_fn(9, |i, _| p[0] - y(i));
                Ok(Some(Residuals { r, jacobian: DMatrix::from_element(9, 1, 1.0) }))
            };
            let found = minimise(&[0.0], model, |_, _, _| ()).expect("ok").expect("a minimum");
            assert!((found.numbers[0] - 7.0).abs() < 1e-6);
            assert!((found.covariance[(0, 0)].sqrt() / expected - 1.0).abs() < 1e-9);
        }
    }

    /// Simulations are exact to their tolerance only: a step below it ends the search.
    #[test]
    fn rounding_of_the_model_is_no_failure() {
        let model = |p: &[f64]| {
            let noise = 1e-4 * (1e9 * p[0]).sin();
            let r = DVector::from_fn(9, |i, _| p[0] - i as f64 + noise);
            Ok(Some(Residuals { r, jacobian: DMatrix::from_element(9, 1, 1.0) }))
        };
        let found = minimise(&[0.0], model, |_, _, _| ()).expect("ok").expect("a minimum");
        assert!((found.numbers[0] - 4.0).abs() < 1e-3, "{:?}", found.numbers);
    }

    #[test]
    fn numbers_that_count_together_only_are_named() {
        let model = |p: &[f64]| {
            let r = DVector::from_fn(4, |i, _| p[0] + p[1] + p[2] * i as f64);
            let by = |i: usize, k: usize| if k == 2 { i as f64 } else { 1.0 };
            Ok(Some(Residuals { r, jacobian: DMatrix::from_fn(4, 3, by) }))
        };
        let found = minimise(&[1.0; 3], model, |_, _, _| ()).expect("ok");
        assert_eq!(found.err(), Some(Failure::Undetermined(vec![0, 1])));
    }
}
