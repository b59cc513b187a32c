//! Distance of a deformed surface to a target surface.
//!
//! J(u, X) = ∫_Γ d̃²(x) dA      x = ΠX + u
//!
//! d̃² is the smoothly interpolated squared distance of
//! [`DistanceField`](super::DistanceField) [m²], so J is in m⁴.
//!
//! Source: Gjoka et al. 2024, equation (16); the published scenes have the rest
//! measure.

use super::surface_integral::{Density, Patch, Place};
use super::{DistanceField, Equilibrium, Objective};

/// Squared distance of a part of the surface to a target surface.
pub struct Target {
    name: String,
    patch: Patch,
    field: DistanceField,
}

impl Target {
    /// The patch that should reach the field's zero set.
    #[must_use]
    pub fn new(name: &str, patch: Patch, field: DistanceField) -> Self {
        Self { name: name.to_owned(), patch, field }
    }

    fn density(&self, place: &Place) -> Density {
        let (value, gradient) = self.field.squared_distance(&place.x());
        Density { value, by_u: gradient, by_rest: gradient }
    }

    /// Makes ready for all points at once.
    fn prepare(&self, at: &Equilibrium) {
        self.field.prepare(&self.patch.positions(at));
    }
}

impl Objective for Target {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.prepare(at);
        self.patch.value(at, &|place| self.density(place))
    }

    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.prepare(at);
        self.patch.add_du(at, &|place| self.density(place), weight, out);
    }

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.prepare(at);
        self.patch.add_drest(at, &|place| self.density(place), weight, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::tests::Case;
    use crate::objective::{DistanceKind, Measure};
    use crate::testing::sphere;

    #[test]
    fn derivatives_belong_to_the_value() {
        for (degree, scale) in [(1, 1.0), (2, 1.0), (2, 1e-3), (3, 1e-3)] {
            let case = Case::cube(degree, scale);
            let mut ball = sphere(2);
            ball.vertices.iter_mut().for_each(|v| *v *= 0.8 * scale);
            for kind in [DistanceKind::Squared, DistanceKind::Unsigned, DistanceKind::Signed] {
                for measure in [Measure::Rest, Measure::Deformed] {
                    let field = DistanceField::new(&ball, 0.4 * scale, kind);
                    let patch = Patch::new(&case.space, &case.facets, measure);
                    // d̃² is once continuously differentiable: small steps keep
                    // within one cell of its lattice, or cross few of its sides
                    case.check(&Target::new("t", patch, field));
                }
            }
        }
    }
}
