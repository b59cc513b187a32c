//! Gradient of an objective at an equilibrium.
//!
//! G(u, X) = ∂E/∂u = 0 on the free degrees of freedom, so
//!
//! H λ = −∂J/∂u      dJ/dX = ∂J/∂X + λᵀ ∂²E/∂u∂X
//!
//! with the exact Hessian H = ∂²E/∂u² at the equilibrium.

use std::time::Instant;

use mesh::Vec3;

use crate::forward::System;
use crate::math::linear::norm;

/// Relative residual of the adjoint system.
const TOLERANCE: f64 = 1e-9;

/// The adjoint system has no accurate solution.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error(
    "the adjoint system was solved only to a relative residual of {residual:.1e}, wanted {TOLERANCE:.0e}: the equilibrium is at a limit point or bifurcation"
)]
pub struct Singular {
    /// Relative residual reached.
    pub residual: f64,
}

/// Adds the implicit part λᵀ ∂²E/∂u∂X to `out`, three components per vertex,
/// given ∂J/∂u at the equilibrium `u` under the full load, at which the system
/// has been linearised.
///
/// # Errors
/// [`Singular`] when H has no accurate inverse.
pub fn add_implicit(
    system: &mut System,
    rest: &[Vec3],
    u: &[f64],
    du: &[f64],
    out: &mut [f64],
) -> Result<(), Singular> {
    let mut lambda = system.restrict(du);
    if norm(&lambda) == 0.0 {
        return Ok(());
    }
    lambda.iter_mut().for_each(|l| *l = -*l);
    let start = Instant::now();
    let rhs = lambda.clone();
    let mut residual = system.linear.solve(&mut lambda);
    if (residual.is_nan() || residual > TOLERANCE) && system.linear.sharpen() {
        lambda = rhs;
        residual = system.linear.solve(&mut lambda);
    }
    system.timings.solve_s += start.elapsed().as_secs_f64();
    if residual.is_nan() || residual > TOLERANCE {
        return Err(Singular { residual });
    }
    let lambda = system.prolong(&lambda);
    let at = system.iterate(rest, u, 1.0);
    for energy in &system.energies {
        energy.add_mixed_vjp(&at, &lambda, out);
    }
    Ok(())
}
