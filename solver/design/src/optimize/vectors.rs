//! Sums and differences of variables.

/// θ + t d.
pub(super) fn along(theta: &[f64], d: &[f64], t: f64) -> Vec<f64> {
    theta.iter().zip(d).map(|(theta, d)| theta + t * d).collect()
}

/// a − b.
pub(super) fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
