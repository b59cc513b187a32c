//! How far a tag moves, whichever way.
//!
//! q = (1/A) ∫ |u| dA      over the rest area A   [m]

use std::sync::Arc;

use anyhow::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Kind, Site, Specification, TAG, form};
use super::means::{Means, OfMeans};
use crate::objective::Objective;

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
        let length = |m: &[Means]| (m[0].length, vec![Means { length: 1.0, ..Means::ZERO }]);
        let tags = [site.body.facets(&self.on)?];
        Ok(Arc::new(OfMeans::new(name, site.space, &tags, Box::new(length))))
    }
}
