//! Distance of a deformed surface to a target surface.
//!
//! J(u, X) = ∫_Γ d̃²(x) dA      x = ΠX + u
//!
//! d̃² is the smoothly interpolated squared distance of
//! [`DistanceField`](super::DistanceField) [m²], so J is in m⁴.
//!
//! Source: Gjoka et al. 2024, equation (16); the published scenes have the rest
//! measure.

use std::path::{Path, PathBuf};

use program::Names;

use super::*;
use crate::quantity::surface_integral::{Density, Place};
use crate::quantity::{DistanceField, DistanceKind};

pub(super) const KIND: Kind = Kind {
    key: "target",
    unit: "m⁴",
    example: "on = 'top'\ntarget = 'target.stl'\ndistance = 'signed'",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// ∫ d̃²(x) dA, d̃ the distance of deformed points to a surface
    #[derive(Debug)]
    struct Keys {
        /// tag, body, or list of them
        on: Names;
        /// surface file in metres
        target: PathBuf;
        /// "squared", "unsigned" (published), "signed" (closed target)
        distance: DistanceKind = DistanceKind::default();
        /// of the distance's lattice [m]
        spacing: f64 = 1e-3, Range::POSITIVE.unit("m");
        /// "rest" or "deformed"
        measure: Measure = Measure::Rest;
    }
}

impl Specification for Keys {
    fn files(&self) -> Vec<&Path> {
        vec![&self.target]
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let field = site.targets.field(&self.target, self.spacing, self.distance)?;
        let patch = Patch::new(site.space, &site.facets(&self.on)?, self.measure);
        Ok(Arc::new(Target { patch, field }))
    }
}

/// Squared distance of a part of the surface to a target surface.
struct Target {
    patch: Patch,
    field: DistanceField,
}

impl Target {
    fn density(&self, place: &Place) -> Density {
        let (value, gradient) = self.field.squared_distance(&place.x());
        Density { value, by_u: gradient, by_rest: gradient }
    }

    /// Makes ready for all points at once.
    fn prepare(&self, at: &Equilibrium) {
        self.field.prepare(&self.patch.positions(at));
    }
}

impl Quantity for Target {
    fn value(&self, at: &Equilibrium) -> f64 {
        self.prepare(at);
        self.patch.value(at, &|place| self.density(place))
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        self.prepare(at);
        self.patch.add_partials(at, &|place| self.density(place), weight, out);
    }
}
