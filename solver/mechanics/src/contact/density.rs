//! Densities of a contact potential: functions of a squared distance s that grow as
//! surfaces come too close.
//!
//! log           b(s, ŝ) = −(s − ŝ)² ln(s/ŝ)   for 0 < s < ŝ, +∞ for s ≤ 0, else 0
//! log-squared   c(s, ŝ) = (s − ŝ)² ln²(s/ŝ)   likewise
//! quadratic     q(s, ŝ) = (s − ŝ)²            for s < ŝ, else 0
//!
//! s, ŝ   squared distance and its activation value [m²];   b, c, q [m⁴]
//!
//! With a minimum distance d₀, s = d² − d₀² and ŝ = d̂² + 2 d₀ d̂, so that b acts
//! for d₀ < d < d₀ + d̂. b is twice continuously differentiable, c three times, q once.
//!
//! With g = s − ŝ and l = ln(s/ŝ):
//!
//! ∂b/∂ŝ = 2 g l + g²/ŝ          ∂²b/∂s∂ŝ = 2 l + 2 g (1/s + 1/ŝ)
//! ∂c/∂ŝ = −2 g l (l + g/ŝ)      ∂²c/∂s∂ŝ = −2 l² − 4 g l (1/s + 1/ŝ) − 2 g²/(s ŝ)
//! ∂q/∂ŝ = −2 g                  ∂²q/∂s∂ŝ = −2
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, eq. 6.

use serde::{Deserialize, Serialize};

/// A function of a squared distance that is zero from the activation distance on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Density {
    /// A log barrier, infinite where surfaces touch or come closer than they may.
    #[default]
    Log,
    /// A log barrier that is smoother and weaker where it begins.
    LogSquared,
    /// (d² − d̂²)².
    Quadratic,
}

impl Density {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Log, Self::LogSquared, Self::Quadratic];

    /// Whether it is infinite where surfaces touch or come closer than they may.
    pub fn is_barrier(self) -> bool {
        self != Self::Quadratic
    }

    /// Its value and first two derivatives by s.
    fn at(self, s: f64, activation: f64) -> [f64; 3] {
        match self {
            Self::Log => log(s, activation),
            Self::LogSquared => log_squared(s, activation),
            Self::Quadratic => quadratic(s, activation),
        }
    }

    /// Derivatives of its value and of its slope by ŝ.
    fn by_activation(self, s: f64, activation: f64) -> [f64; 2] {
        match self {
            Self::Log => log_by_activation(s, activation),
            Self::LogSquared => log_squared_by_activation(s, activation),
            Self::Quadratic => quadratic_by_activation(s, activation),
        }
    }
}

/// β(d²): a density with the distances between which it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repulsion {
    /// The function of distance.
    pub density: Density,
    /// d₀, the minimum distance [m].
    pub minimum: f64,
    /// d̂, the activation distance [m].
    pub activation: f64,
}

impl Repulsion {
    /// Distance from which on β is zero, d₀ + d̂ [m].
    pub fn range(&self) -> f64 {
        self.minimum + self.activation
    }

    /// β [m⁴] and its first two derivatives by d² at a squared distance [m²].
    pub fn at(&self, d2: f64) -> [f64; 3] {
        let s = d2 - self.minimum * self.minimum;
        let activation = self.activation * (self.activation + 2.0 * self.minimum);
        self.density.at(s, activation)
    }

    /// The derivatives of β and ∂β/∂d² by d̂ at a squared distance [m²].
    pub fn by_activation(&self, d2: f64) -> [f64; 2] {
        let s = d2 - self.minimum * self.minimum;
        let activation = self.activation * (self.activation + 2.0 * self.minimum);
        let by = 2.0 * (self.activation + self.minimum);
        self.density.by_activation(s, activation).map(|d| by * d)
    }

    /// Whether a squared distance [m²] is not above the smallest that is allowed.
    pub fn is_violated(&self, d2: f64) -> bool {
        d2 <= self.minimum * self.minimum
    }
}

/// b, ∂b/∂s and ∂²b/∂s²; b is +∞ with derivatives zero for s ≤ 0.
fn log(s: f64, activation: f64) -> [f64; 3] {
    if s <= 0.0 {
        [f64::INFINITY, 0.0, 0.0]
    } else if s < activation {
        let (gap, ratio) = (s - activation, activation / s);
        let log = (s / activation).ln();
        let slope = -gap * (2.0 * log + gap / s);
        [-gap * gap * log, slope, (ratio + 2.0) * ratio - 2.0 * log - 3.0]
    } else {
        [0.0; 3]
    }
}

/// c, ∂c/∂s and ∂²c/∂s²; c is +∞ with derivatives zero for s ≤ 0.
fn log_squared(s: f64, activation: f64) -> [f64; 3] {
    if s <= 0.0 {
        [f64::INFINITY, 0.0, 0.0]
    } else if s < activation {
        let (gap, log) = (s - activation, (s / activation).ln());
        let (product, slope) = (gap * log, log + gap / s);
        let curvature =
            2.0 * log * log + 8.0 * product / s + 2.0 * gap * gap * (1.0 - log) / (s * s);
        [product * product, 2.0 * product * slope, curvature]
    } else {
        [0.0; 3]
    }
}

/// q, ∂q/∂s and ∂²q/∂s², which jumps at ŝ.
fn quadratic(s: f64, activation: f64) -> [f64; 3] {
    let gap = (s - activation).min(0.0);
    [gap * gap, 2.0 * gap, if gap < 0.0 { 2.0 } else { 0.0 }]
}

/// ∂b/∂ŝ and ∂²b/∂s∂ŝ; zero where b is infinite.
fn log_by_activation(s: f64, activation: f64) -> [f64; 2] {
    if s <= 0.0 || s >= activation {
        return [0.0; 2];
    }
    let (gap, log) = (s - activation, (s / activation).ln());
    [gap * (2.0 * log + gap / activation), 2.0 * log + 2.0 * gap * (1.0 / s + 1.0 / activation)]
}

/// ∂c/∂ŝ and ∂²c/∂s∂ŝ; zero where c is infinite.
fn log_squared_by_activation(s: f64, activation: f64) -> [f64; 2] {
    if s <= 0.0 || s >= activation {
        return [0.0; 2];
    }
    let (gap, log) = (s - activation, (s / activation).ln());
    let both = 1.0 / s + 1.0 / activation;
    let mixed = -2.0 * log * log - 4.0 * gap * log * both - 2.0 * gap * gap / (s * activation);
    [-2.0 * gap * log * (log + gap / activation), mixed]
}

/// ∂q/∂ŝ and ∂²q/∂s∂ŝ, which jumps at ŝ.
fn quadratic_by_activation(s: f64, activation: f64) -> [f64; 2] {
    let gap = (s - activation).min(0.0);
    [-2.0 * gap, if gap < 0.0 { -2.0 } else { 0.0 }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_belong_to_their_functions() {
        for density in Density::ALL {
            let function = |s: f64| density.at(s, 1.0);
            for s in [0.01, 0.3, 0.9, 0.999] {
                let h = 1e-6 * s;
                let (low, exact, high) = (function(s - h), function(s), function(s + h));
                for k in 0..2 {
                    let difference = (high[k] - low[k]) / (2.0 * h);
                    // truncation h² b‴/6 is below 1e-9 b′, rounding 1e-16 b / h
                    let error = (difference - exact[k + 1]).abs();
                    assert!(error < 1e-8 * (1.0 + exact[k + 1].abs()));
                }
            }
        }
        for density in Density::ALL {
            let at = |activation: f64| Repulsion { density, minimum: 0.2, activation };
            for d2 in [0.05, 0.3, 1.2] {
                let h = 1e-6;
                let (low, exact, high) =
                    (at(1.0 - h).at(d2), at(1.0).by_activation(d2), at(1.0 + h).at(d2));
                for k in 0..2 {
                    let difference = (high[k] - low[k]) / (2.0 * h);
                    // as above
                    let error = (difference - exact[k]).abs();
                    assert!(error < 1e-8 * (1.0 + exact[k].abs()), "{error:e}");
                }
            }
        }
        for density in Density::ALL {
            let at = |s| density.at(s, 1.0);
            assert_eq!(at(1.0), [0.0; 3]);
            assert_eq!(at(0.0)[0].is_infinite(), density.is_barrier());
            let jumps = at(1.0 - 1e-9)[2].abs() > 1e-8;
            assert_eq!(jumps, density == Density::Quadratic, "the curvature is continuous");
            // it grows as surfaces come closer
            assert!(at(0.3)[0] > at(0.5)[0] && at(0.5)[1] < 0.0 && at(0.5)[2] > 0.0);
        }
    }
}
