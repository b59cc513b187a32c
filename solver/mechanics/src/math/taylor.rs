//! Taylor test: does a gradient belong to its function?
//!
//! r₀(ε) = |J(θ + εq) − J(θ)|               = O(ε)
//! r₁(ε) = |J(θ + εq) − J(θ) − ε g·q|       = O(ε²)   when g is the gradient
//!
//! Source: Farrell et al. 2013, doi:10.1137/120873558, section 4.

use serde::Serialize;

/// Remainders along one direction.
#[derive(Clone, Debug, Serialize)]
pub struct Taylor {
    /// Step lengths ε, halved from one to the next.
    pub epsilon: Vec<f64>,
    /// First-order remainders r₁(ε).
    pub remainder: Vec<f64>,
    /// Slope of log r₁ against log ε: 2 for an exact gradient.
    pub slope: f64,
    /// Slope of log r₀ against log ε: 1 unless g·q vanishes.
    pub slope_without_gradient: f64,
}

/// Runs the test with ε = `epsilon`·2⁻ᵏ, k = 0 … `steps` − 1.
///
/// `directional` is g·q and `value(ε)` is J(θ + εq).
pub fn taylor<E>(
    epsilon: f64,
    steps: i32,
    directional: f64,
    mut value: impl FnMut(f64) -> Result<f64, E>,
) -> Result<Taylor, E> {
    let start = value(0.0)?;
    let epsilon: Vec<f64> = (0..steps).map(|k| epsilon * 0.5_f64.powi(k)).collect();
    let mut remainder = Vec::new();
    let mut change = Vec::new();
    for &e in &epsilon {
        let difference = value(e)? - start;
        change.push(difference.abs());
        remainder.push((difference - e * directional).abs());
    }
    let slope = log_slope(&epsilon, &remainder);
    let slope_without_gradient = log_slope(&epsilon, &change);
    Ok(Taylor { epsilon, remainder, slope, slope_without_gradient })
}

/// Least-squares slope of log y against log x.
pub fn log_slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (lx, ly): (Vec<f64>, Vec<f64>) =
        (x.iter().map(|v| v.ln()).collect(), y.iter().map(|v| v.ln()).collect());
    let (mx, my) = (lx.iter().sum::<f64>() / n, ly.iter().sum::<f64>() / n);
    let covariance: f64 = lx.iter().zip(&ly).map(|(a, b)| (a - mx) * (b - my)).sum();
    let variance: f64 = lx.iter().map(|a| (a - mx).powi(2)).sum();
    covariance / variance
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn run(directional: f64) -> Taylor {
        let cube = |e: f64| Ok::<f64, Infallible>((1.0 + e).powi(3));
        match taylor(1e-2, 7, directional, cube) {
            Ok(result) => result,
            Err(never) => match never {},
        }
    }

    #[test]
    fn the_right_gradient_gives_two_and_a_wrong_one_gives_one() {
        assert!((run(3.0).slope - 2.0).abs() < 0.02);
        assert!((run(3.1).slope - 1.0).abs() < 0.2);
        assert!((run(3.0).slope_without_gradient - 1.0).abs() < 0.02);
    }
}
