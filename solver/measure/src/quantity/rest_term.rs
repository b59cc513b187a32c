//! Quantities of the rest shape alone.

use mesh::Vec3;

use super::{Equilibrium, Partials, Quantity};

/// A quantity q(X) that no displacement or force changes.
pub trait RestTerm: Send + Sync {
    /// Whether the rest shape is admissible.
    fn admit(&self, _rest: &[Vec3]) -> Result<(), String> {
        Ok(())
    }
    /// Computes q at rest positions. Infinite where they are not admissible.
    fn value_at(&self, rest: &[Vec3]) -> f64;
    /// Adds `weight` ∂q/∂X, three components per vertex; q must be finite.
    fn add_gradient_at(&self, rest: &[Vec3], weight: f64, out: &mut [f64]);
}

impl<T: RestTerm> Quantity for T {
    fn admit(&self, rest: &[Vec3]) -> Result<(), String> {
        RestTerm::admit(self, rest)
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.value_at(at.rest)
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        self.add_gradient_at(at.rest, weight, out.rest);
    }
}
