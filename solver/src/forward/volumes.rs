//! Equilibria with prescribed volumes, by the method of multipliers.
//!
//! Newton's method finds the u that minimises the augmented Lagrangian
//!
//! E(u) − Σ P̂ (V(u) − V*) + ½ k (V(u) − V*)²
//!
//! then P̂ ← P̂ − k (V − V*), until V = V*. The penalty k grows where a gap closes
//! slowly. Beyond a limit point, where no pressure can be prescribed, the
//! quadratic term keeps the Lagrangian convex across the constraint.
//!
//! Source: Nocedal and Wright, "Numerical Optimization", section 17.3.

use mesh::Vec3;

use super::{Failure, Newton, System};
use crate::energy::Constraint;

/// Updates of the pressures before a volume counts as out of reach.
const UPDATES: usize = 40;
/// A gap that is left larger than this fraction asks for more penalty ...
const SLOW: f64 = 0.1;
/// ... by this factor.
const GROWTH: f64 = 10.0;

/// Moves `u` to an equilibrium at which every prescribed volume is reached to
/// Newton's relative tolerance; returns all Newton iterations and the residual
/// [N].
///
/// # Errors
/// [`Failure`]; `u` is then the last state.
pub fn balance(
    system: &mut System,
    rest: &[Vec3],
    u: &mut Vec<f64>,
    load: f64,
    newton: &Newton,
) -> Result<(usize, f64), Failure> {
    let mut iterations = 0;
    let mut last = vec![f64::INFINITY; system.multipliers.len()];
    for update in 0.. {
        let (count, residual) = newton.solve(system, rest, u, load)?;
        iterations += count;
        let constraints = system.constraints(rest, u, load);
        let gap = |c: &Constraint| (c.volume / c.wanted - 1.0).abs();
        let Some(worst) = constraints.iter().max_by(|a, b| gap(a).total_cmp(&gap(b))) else {
            return Ok((iterations, residual));
        };
        log::debug!("volumes {update}  largest gap {:.2e}", gap(worst));
        if gap(worst) <= newton.relative {
            return Ok((iterations, residual));
        }
        if update == UPDATES {
            return Err(Failure::Volume { volume: worst.volume, wanted: worst.wanted });
        }
        for constraint in &constraints {
            let multiplier = &mut system.multipliers[constraint.multiplier];
            let last = &mut last[constraint.multiplier];
            multiplier.pressure -= multiplier.penalty * (constraint.volume - constraint.wanted);
            if gap(constraint) > newton.relative.max(SLOW * *last) {
                multiplier.penalty *= GROWTH;
            }
            *last = gap(constraint);
        }
    }
    unreachable!("the loop ends by returning")
}
