//! How far a tag moves, whichever way.
//!
//! q = (1/A) ∫ |u| dA      over the rest area A   [m]
//!
//! Where a point does not move, |u| has no derivative; zero is taken, the least of its subgradients.

use std::sync::Arc;

use anyhow::Result;
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Kind, Site, Specification, TAG, form};
use crate::objective::surface_integral::{Density, Patch, Place};
use crate::objective::{Equilibrium, Measure, Objective};

pub(super) const KIND: Kind = Kind {
    key: "displacement-magnitude",
    formula: "mean length of a tag's displacement, ∫ |u| dA / A over its rest area",
    unit: "m",
    keys: &[TAG],
    needs_contact: false,
    form: form::<Keys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: String,
}

impl Specification for Keys {
    fn build(&self, name: &str, site: &Site) -> Result<Arc<dyn Objective>> {
        let patch = Patch::new(site.space, &site.body.facets(&self.on)?, Measure::Rest);
        Ok(Arc::new(Magnitude { name: name.to_owned(), patch }))
    }
}

struct Magnitude {
    name: String,
    patch: Patch,
}

impl Magnitude {
    /// Rest area A [m²] and q [m].
    fn area_and_mean(&self, at: &Equilibrium) -> (f64, f64) {
        let points = self.patch.points(at);
        let area: f64 = points.iter().map(|(_, part)| part).sum();
        let mean = points.iter().map(|(place, part)| place.u.norm() * part / area).sum();
        (area, mean)
    }

    /// The density whose integral has the derivatives of q.
    fn density(&self, at: &Equilibrium) -> impl Fn(&Place) -> Density {
        let (area, mean) = self.area_and_mean(at);
        move |place| Density {
            value: (place.u.norm() - mean) / area,
            by_u: place.u.try_normalize(0.0).unwrap_or(Vec3::zeros()) / area,
            by_rest: Vec3::zeros(),
        }
    }
}

impl Objective for Magnitude {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.area_and_mean(at).1
    }

    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.patch.add_du(at, &self.density(at), weight, out);
    }

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.patch.add_drest(at, &self.density(at), weight, out);
    }
}
