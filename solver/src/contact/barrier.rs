//! Functions of a squared distance s that grow as surfaces come too close.
//!
//! log         b(s, ŝ) = −(s − ŝ)² ln(s/ŝ) for 0 < s < ŝ, +∞ for s ≤ 0, else 0
//! quadratic   q(s, ŝ) = (s − ŝ)²          for s < ŝ, else 0
//!
//! s, ŝ   squared distance and its activation value [m²];   b, q [m⁴]
//!
//! With a minimum distance d₀, s = d² − d₀² and ŝ = d̂² + 2 d₀ d̂, so that b acts
//! for d₀ < d < d₀ + d̂. b is twice continuously differentiable, q once.
//!
//! Sources: Li et al. 2020, doi:10.1145/3386569.3392425, eq. 6; scale of the
//! convergent form: Li et al. 2023, "Convergent Incremental Potential Contact",
//! arXiv:2307.15908.

use serde::{Deserialize, Serialize};

/// How pairs are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// By areas, so that the potential is that of a surface and converges as
    /// meshes are refined.
    #[default]
    Convergent,
    /// By areas as well, but nearly all of it by vertices and triangles, so that it
    /// does not depend on how meshes lie on each other: between flat surfaces each
    /// edge meets several others, of which the convergent form counts all.
    Even,
    /// Every pair alike, so that it grows with the number of facets.
    Plain,
}

/// What edges with edges have of the even form. It makes them a barrier still; an
/// edge of one skin that crosses five of the other adds 0.8 % to what it should.
const EDGES: f64 = 1e-3;

impl Form {
    /// What areas of vertices, and those of edges, count with their features. All
    /// together count an area of two surfaces once where each edge of one crosses
    /// one of the other.
    #[must_use]
    pub fn shares(self) -> [f64; 2] {
        match self {
            Self::Convergent | Self::Plain => [0.25, 0.25],
            Self::Even => [0.5 - EDGES, EDGES],
        }
    }
}

/// The barrier κ σ b between surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// How pairs are weighted.
    pub form: Form,
    /// d̂ [m].
    pub activation: f64,
    /// κ [Pa]; [J/m⁴] in the plain form.
    pub stiffness: f64,
    /// d₀ [m].
    pub thickness: f64,
}

impl Barrier {
    /// Distance below which it acts, d₀ + d̂ [m].
    #[must_use]
    pub fn range(&self) -> f64 {
        self.thickness + self.activation
    }

    /// κ σ, with σ = 1 / (d̂ (d̂ + 2 d₀)²) where areas weigh, else one
    /// [J/m⁶; J/m⁴].
    #[must_use]
    pub fn scale(&self) -> f64 {
        let full = self.activation + 2.0 * self.thickness;
        match self.form {
            Form::Convergent | Form::Even => self.stiffness / (self.activation * full * full),
            Form::Plain => self.stiffness,
        }
    }

    /// b and its derivatives by d² at a squared distance.
    #[must_use]
    pub fn at(&self, d2: f64) -> [f64; 3] {
        let full = self.activation + 2.0 * self.thickness;
        log_barrier(d2 - self.thickness * self.thickness, self.activation * full)
    }
}

/// b, ∂b/∂s and ∂²b/∂s²; b is +∞ with derivatives zero for s ≤ 0.
#[must_use]
pub fn log_barrier(s: f64, activation: f64) -> [f64; 3] {
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

/// q, ∂q/∂s and ∂²q/∂s², which jumps at ŝ.
#[must_use]
pub fn quadratic(s: f64, activation: f64) -> [f64; 3] {
    let gap = (s - activation).min(0.0);
    [gap * gap, 2.0 * gap, if gap < 0.0 { 2.0 } else { 0.0 }]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gaps at which a wall presses on a plate, from a table that was solved
    /// for independently: κ = 10⁵ Pa, weight one per area.
    #[test]
    fn pressures_leave_the_known_gaps_for_any_activation() {
        for activation in [1.0, 1e-3, 5e-5] {
            let form = Form::Convergent;
            let barrier = Barrier { form, activation, stiffness: 1e5, thickness: 0.0 };
            for (pressure, gap) in [(1e2, 0.9935), (1e3, 0.979), (1e4, 0.934), (6e4, 0.833)] {
                let force = |gap: f64| {
                    let d = gap * activation;
                    -barrier.scale() * barrier.at(d * d)[1] * 2.0 * d
                };
                // the gaps are given to three or four digits
                let digits = if gap > 0.99 { 0.5e-4 } else { 0.5e-3 };
                assert!(force(gap - digits) > pressure && force(gap + digits) < pressure);
            }
        }
    }

    #[test]
    fn derivatives_belong_to_their_functions() {
        let log = (|s| log_barrier(s, 1.0)) as fn(f64) -> [f64; 3];
        for function in [log, |s| quadratic(s, 1.0)] {
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
        assert_eq!(log_barrier(1.0, 1.0), [0.0; 3]);
        assert!(log_barrier(1.0 - 1e-9, 1.0)[2].abs() < 1e-8, "the curvature is continuous");
        assert_eq!(quadratic(1.0, 1.0), [0.0; 3]);
        assert_eq!(log_barrier(0.0, 1.0)[0], f64::INFINITY);
    }
}
