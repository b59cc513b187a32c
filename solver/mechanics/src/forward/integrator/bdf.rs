//! Backward differentiation formulas (BDF).
//!
//! vₙ = (uₙ − Σ αᵢ uₙ₋ᵢ) / h,   aₙ = (vₙ − Σ αᵢ vₙ₋ᵢ) / h,   h = β Δt
//!
//! 1 state (implicit Euler)   α = 1;                     β = 1
//! 2 states                   α = 4/3, −1/3;             β = 2/3
//! 3 states                   α = 18/11, −9/11, 2/11;    β = 6/11
//!
//! Source: Hairer, Nørsett and Wanner, "Solving Ordinary Differential Equations I", III.1.

use super::{Formula, Growth, Weights};

/// α and β of the formulas with 1, 2 and 3 states.
const FORMULAS: [(&[f64], f64); 3] = [
    (&[1.0], 1.0),
    (&[4.0 / 3.0, -1.0 / 3.0], 2.0 / 3.0),
    (&[18.0 / 11.0, -9.0 / 11.0, 2.0 / 11.0], 6.0 / 11.0),
];

/// Growth by the formula with 3 states, which is not A-stable: that of the largest root z of
/// z³ (1 − i β ω Δt) = Σ αᵢ z³⁻ⁱ. Above ω Δt = √15/2 all roots are below 1.
pub const GROWTH_OF_THREE_STATES: Growth =
    Growth { factor: 1.0456, phase: 1.14, largest_phase: 1.9365 };

/// The formula with 1, 2 or 3 states, for a step of length Δt [s].
pub fn formula(states: usize, dt: f64) -> Formula {
    let (alpha, beta) = FORMULAS[states - 1];
    let weights = |&a: &f64| Weights { history: [a, 0.0, 0.0], velocity: [a, 0.0], internal: a };
    let h = beta * dt;
    Formula { h, k: h, internal_h: h, past: alpha.iter().map(weights).collect() }
}
