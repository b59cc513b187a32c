//! Implicit Newmark of average acceleration, the trapezoidal rule.
//!
//! uₙ = uₙ₋₁ + Δt vₙ₋₁ + Δt² ((½ − β) aₙ₋₁ + β aₙ),   vₙ = vₙ₋₁ + Δt ((1 − γ) aₙ₋₁ + γ aₙ)
//!
//! with β = ¼ and γ = ½: stable for any step, second order, and it damps nothing, so that
//! oscillations that the step does not resolve stay. In terms of the velocity:
//!
//! h = β Δt / γ,   k = γ Δt
//! history       = uₙ₋₁ + Δt (1 − β/γ) vₙ₋₁ + Δt² (½ − β/γ) aₙ₋₁
//! past velocity = vₙ₋₁ + Δt (1 − γ) aₙ₋₁
//!
//! Internal variables go by the backward formula of two states, also of second order, as their
//! rates are not kept.
//!
//! Source: Newmark 1959, "A Method of Computation for Structural Dynamics",
//! doi:10.1061/JMCEA3.0000098.

use super::{Formula, Weights, bdf};

const BETA: f64 = 0.25;
const GAMMA: f64 = 0.5;

/// The formula of a step of length Δt [s] from a state with its acceleration.
pub fn formula(dt: f64) -> Formula {
    let ratio = BETA / GAMMA;
    let backward = bdf::formula(2, dt);
    let mut past: Vec<Weights> = backward
        .past
        .iter()
        .map(|of| Weights { internal: of.internal, ..Weights::default() })
        .collect();
    past[0].history = [1.0, dt * (1.0 - ratio), dt * dt * (0.5 - ratio)];
    past[0].velocity = [1.0, dt * (1.0 - GAMMA)];
    Formula { h: ratio * dt, k: GAMMA * dt, internal_h: backward.h, past }
}
