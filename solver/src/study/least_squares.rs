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
use nalgebra::{DMatrix, DVector, SymmetricEigen};

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
    /// r at the start.
    pub before: DVector<f64>,
    /// C.
    pub covariance: DMatrix<f64>,
    /// Steps that were taken.
    pub iterations: usize,
}

impl Minimum {
    /// The standard error of a number: √C_kk.
    pub fn standard_error(&self, k: usize) -> f64 {
        self.covariance[(k, k)].sqrt()
    }

    /// ν: measurements less numbers.
    pub fn degrees_of_freedom(&self) -> usize {
        self.residuals.r.len().saturating_sub(self.numbers.len())
    }
}

/// Why there is no minimum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The model has no value at the start.
    Start,
    /// Some combination of these numbers changes no residual.
    Undetermined(Vec<usize>),
    /// χ² still falls after the last iteration, or its derivatives do not belong to it.
    Unsettled(usize),
}

impl Failure {
    /// For people: the numbers have names, and there are so many measurements.
    pub fn in_words(&self, names: &[String], measurements: usize) -> String {
        match self {
            Self::Start => "there is no equilibrium with the numbers as they are; mend the scene first by solver simulate"
                .to_owned(),
            Self::Undetermined(which) => format!(
                "{measurements} measurements do not determine {}: changes of {} leave all of them as they are; measure \
                 something that tells them apart, or seek fewer",
                which.iter().map(|&k| names[k].as_str()).collect::<Vec<_>>().join(" and "),
                if which.len() > 1 { "these numbers together" } else { "this number" }
            ),
            Self::Unsettled(iterations) => format!("no minimum after {iterations} iterations"),
        }
    }
}

/// What a model says of measurements (value, σ), and its derivatives, as residuals; none where one is not finite.
pub fn residuals(
    (mut r, mut jacobian): (DVector<f64>, DMatrix<f64>),
    measurements: &[(f64, f64)],
) -> Option<Residuals> {
    for (i, (measured, uncertainty)) in measurements.iter().enumerate() {
        r[i] = (r[i] - measured) / uncertainty;
        jacobian.row_mut(i).scale_mut(1.0 / uncertainty);
    }
    let is_finite = r.iter().chain(jacobian.iter()).all(|value| value.is_finite());
    is_finite.then_some(Residuals { r, jacobian })
}

/// The minimum from a start; the log shows each iteration. `model` gives none where it cannot be evaluated.
pub fn minimise(
    names: &[String],
    start: &[f64],
    mut model: impl FnMut(&[f64]) -> Result<Option<Residuals>>,
) -> Result<Result<Minimum, Failure>> {
    let Some(first) = model(start)? else { return Ok(Err(Failure::Start)) };
    let before = first.r.clone();
    let mut at = LevenbergMarquardt::new(start, first);
    for iterations in 0..=ITERATIONS {
        let named: Vec<_> = names.iter().zip(&at.x).map(|(n, v)| format!("{n} {v:.5e}")).collect();
        let chi2 = at.residuals.sum();
        log::info!("iteration {iterations}  χ² {chi2:.4e}  {}", named.join("  "));
        let normal = at.residuals.normal();
        let free = undetermined(&normal);
        if !free.is_empty() {
            return Ok(Err(Failure::Undetermined(free)));
        }
        let inverse = normal.try_inverse().expect("regular, as its eigenvalues say");
        let whole = -(&inverse * at.residuals.jacobian.tr_mul(&at.residuals.r));
        let within =
            |part: f64| (0..whole.len()).all(|k| whole[k].abs() <= part * inverse[(k, k)].sqrt());
        let mut settled = within(SETTLED_STEP);
        while !settled && !at.advance(&mut model)?.helped {
            settled = within(SIMULATION_ROUNDING);
            if !settled && at.damping > LARGEST_DAMPING {
                return Ok(Err(Failure::Unsettled(iterations)));
            }
        }
        if settled {
            let LevenbergMarquardt { x: numbers, residuals, .. } = at;
            let mut found = Minimum { numbers, residuals, before, covariance: inverse, iterations };
            let over = found.degrees_of_freedom();
            if over > 0 {
                found.covariance *= (found.residuals.sum() / over as f64).max(1.0);
            }
            return Ok(Ok(found));
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
    use super::*;

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
            let found = minimise(&[], &[0.0], model).expect("a model").expect("a minimum");
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
        let found = minimise(&[], &[0.0], model).expect("a model").expect("a minimum");
        assert!((found.numbers[0] - 4.0).abs() < 1e-3, "{:?}", found.numbers);
    }
}
