//! Energy–momentum: forces along the chord of the step, see [`chord`](crate::energy::chord).
//!
//! uₙ = uₙ₋₁ + ½ Δt (vₙ₋₁ + vₙ),   vₙ = vₙ₋₁ + Δt M⁻¹ F        F: mean force along the chord
//!
//! As the forces of a potential do −ΔE of work along the chord, kinetic and potential energy together stay as they
//! are, whatever the step. Second order. In terms of the velocity:
//!
//! h = ½ Δt,   k = Δt
//! history = uₙ₋₁ + ½ Δt vₙ₋₁,   past velocity = vₙ₋₁
//!
//! Internal variables go by the backward formula of one state.

use super::{Formula, Weights};

/// The formula of a step of length Δt [s] from one state.
pub fn formula(dt: f64) -> Formula {
    let past = Weights { history: [1.0, 0.5 * dt, 0.0], velocity: [1.0, 0.0], internal: 1.0 };
    Formula { h: 0.5 * dt, k: dt, internal_h: dt, past: vec![past] }
}
