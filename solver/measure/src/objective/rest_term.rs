//! Terms of the rest shape alone.

use mesh::Vec3;

use super::{Equilibrium, Objective};

/// One term J(X) that no displacement or force changes.
pub trait RestTerm: Send + Sync {
    /// The user's name for this term.
    fn name(&self) -> &str;
    /// Whether the rest shape is admissible.
    ///
    /// # Errors
    /// Why it is not, with numbers.
    fn admit(&self, _rest: &[Vec3]) -> Result<(), String> {
        Ok(())
    }
    /// J at rest positions. Infinite where they are not admissible.
    fn value_at(&self, rest: &[Vec3]) -> f64;
    /// Adds `weight` ∂J/∂X, three components per vertex; J must be finite.
    fn add_gradient_at(&self, rest: &[Vec3], weight: f64, out: &mut [f64]);
}

impl<T: RestTerm> Objective for T {
    fn name(&self) -> &str {
        RestTerm::name(self)
    }

    fn admit(&self, rest: &[Vec3]) -> Result<(), String> {
        RestTerm::admit(self, rest)
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.value_at(at.rest)
    }

    fn add_du(&self, _: &Equilibrium, _: f64, _: &mut [f64]) {}

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.add_gradient_at(at.rest, weight, out);
    }
}
