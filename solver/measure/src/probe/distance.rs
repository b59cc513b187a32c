//! Distance of two tags.
//!
//! q = |x̄₁ − x̄₂|      x̄ the mean deformed position over the tag's rest area   [m]

use std::sync::Arc;

use anyhow::Result;
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Kind, OTHER_TAG, Site, Specification, TAG, form};
use super::means::{Means, OfMeans};
use crate::objective::Objective;

pub(super) const KIND: Kind = Kind {
    key: "distance",
    formula: "distance of the mean positions of two tags",
    unit: "m",
    keys: &[TAG, OTHER_TAG],
    needs_contact: false,
    form: form::<Keys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    on: String,
    to: String,
}

impl Specification for Keys {
    fn build(&self, name: &str, site: &Site) -> Result<Arc<dyn Objective>> {
        let tags = [site.body.facets(&self.on)?, site.body.facets(&self.to)?];
        Ok(Arc::new(OfMeans::new(name, site.space, &tags, Box::new(distance))))
    }
}

fn distance(m: &[Means]) -> (f64, Vec<Means>) {
    let apart = m[0].x() - m[1].x();
    let by = apart.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
    (apart.norm(), vec![Means::by_x(by), Means::by_x(-by)])
}
