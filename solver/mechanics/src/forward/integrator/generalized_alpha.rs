//! Generalized-α with forces at the end of the step (α_f = 0; Wood, Bossak and Zienkiewicz).
//!
//! M ((1 − α) aₙ + α aₙ₋₁) = Fₙ,   u and v as in Newmark's method
//! α = (ρ − 1)/(ρ + 1),   γ = ½ − α,   β = ¼ (1 − α)²
//!
//! It is stable for any step, of second order, and damps what the step does not resolve: in each step
//! by the factor ρ where ω Δt → ∞, hardly where ω Δt is small. With the balanced acceleration
//! ã = F/M, the combination of two steps has no other one, for c = α/(1 − α):
//!
//! vₙ − vₙ₋₁ + c (vₙ₋₁ − vₙ₋₂) = Δt ((1 − γ) ãₙ₋₁ + γ ãₙ) / (1 − α)
//! uₙ − uₙ₋₁ + c (uₙ₋₁ − uₙ₋₂) = Δt (vₙ₋₁ + c vₙ₋₂) + Δt² ((½ − β) ãₙ₋₁ + β ãₙ) / (1 − α)
//!
//! With ρ = 1 it is the method of Newmark of average acceleration, the trapezoidal rule, γ = ½ and β = ¼: it damps nothing,
//! so that oscillations that the step does not resolve stay.
//!
//! Internal variables go by the backward formula of two states, also of second order, as their rates are not kept.
//!
//! Source: Chung and Hulbert 1993, "A Time Integration Algorithm for Structural Dynamics With
//! Improved Numerical Dissipation", doi:10.1115/1.2900803; the combination is ours. Newmark 1959, "A Method of
//! Computation for Structural Dynamics", doi:10.1061/JMCEA3.0000098.

use super::{Formula, Weights, bdf};

/// Factor by which a step damps the fastest oscillations [1].
pub(super) const SPECTRAL_RADIUS: f64 = 0.8;

/// The formula of a step of length Δt [s] from two states, of which the last has its acceleration, by the factor ρ.
pub fn formula(dt: f64, rho: f64) -> Formula {
    let alpha = (rho - 1.0) / (rho + 1.0);
    let (gamma, beta) = (0.5 - alpha, 0.25 * (1.0 - alpha).powi(2));
    let (c, scale, ratio) = (alpha / (1.0 - alpha), dt / (1.0 - alpha), beta / gamma);
    let h = ratio * dt;
    let backward = bdf::formula(2, dt);
    let weights = |history, velocity, state: usize| {
        let internal = backward.past[state].internal;
        Weights { history, velocity, internal }
    };
    let last = [1.0 - c, dt - h * (1.0 - c), scale * dt * (0.5 - ratio)];
    let before = [c, c * (dt - h), 0.0];
    let past =
        vec![weights(last, [1.0 - c, scale * (1.0 - gamma)], 0), weights(before, [c, 0.0], 1)];
    Formula { h, k: scale * gamma, internal_h: backward.h, past }
}
