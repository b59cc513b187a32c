//! Mean displacement of a tag.
//!
//! q = a · (1/A) ∫ u dA      over the rest area A, a the unit vector along the axis   [m]

use std::sync::Arc;

use anyhow::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::kind::{AXIS, Kind, Site, Specification, TAG, form};
use super::means::{Means, OfMeans};
use crate::objective::Objective;

pub(super) const KIND: Kind = Kind {
    key: "displacement",
    formula: "mean displacement of a tag along an axis, a · ∫ u dA / A over its rest area",
    unit: "m",
    keys: &[TAG, AXIS],
    needs_contact: false,
    form: form::<Keys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: String,
    axis: Axis,
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        self.axis.check()
    }

    fn build(&self, name: &str, site: &Site) -> Result<Arc<dyn Objective>> {
        let a = self.axis.unit();
        let along = move |m: &[Means]| (a.dot(&m[0].u), vec![Means { u: a, ..Means::ZERO }]);
        let tags = [site.body.facets(&self.on)?];
        Ok(Arc::new(OfMeans::new(name, site.space, &tags, Box::new(along))))
    }
}
