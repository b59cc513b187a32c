//! Functions of a squared distance s that grow as surfaces come too close.
//!
//! log         b(s, ŝ) = −(s − ŝ)² ln(s/ŝ) for 0 < s < ŝ, +∞ for s ≤ 0, else 0
//! quadratic   q(s, ŝ) = (s − ŝ)²          for s < ŝ, else 0
//!
//! s, ŝ   squared distance and its activation value [m²];   b, q [m⁴]
//!
//! With a minimum distance d₀, s = d² − d₀² and ŝ = d̂² + 2 d₀ d̂, so that b acts
//! for d₀ < d < d₀ + d̂.
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, eq. 6.

/// b and ∂b/∂s; b is +∞ with derivative zero for s ≤ 0.
#[must_use]
pub fn log_barrier(s: f64, activation: f64) -> (f64, f64) {
    if s <= 0.0 {
        (f64::INFINITY, 0.0)
    } else if s < activation {
        let (gap, log) = (s - activation, (s / activation).ln());
        (-gap * gap * log, -gap * (2.0 * log + gap / s))
    } else {
        (0.0, 0.0)
    }
}

/// q and ∂q/∂s.
#[must_use]
pub fn quadratic(s: f64, activation: f64) -> (f64, f64) {
    let gap = (s - activation).min(0.0);
    (gap * gap, 2.0 * gap)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_belong_to_their_functions() {
        for function in [log_barrier, quadratic] {
            for s in [0.01, 0.3, 0.9, 0.999] {
                let h = 1e-6 * s;
                let difference = (function(s + h, 1.0).0 - function(s - h, 1.0).0) / (2.0 * h);
                let derivative = function(s, 1.0).1;
                // truncation h² b'''/6 is below 1e-9 b', rounding 1e-16 b / h
                assert!((difference - derivative).abs() < 1e-8 * (1.0 + derivative.abs()));
            }
            assert_eq!(function(1.0, 1.0), (0.0, 0.0));
        }
        assert_eq!(log_barrier(0.0, 1.0).0, f64::INFINITY);
    }
}
