//! Volume of a chamber behind its deformed wall, as in [`Volume`]   [m³].

use std::sync::Arc;

use anyhow::Result;
use mechanics::energy::Wall;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Kind, Site, Specification, form};
use crate::objective::{Measure, Objective, Volume};

pub(super) const KIND: Kind = Kind {
    key: "volume",
    formula: "volume of a chamber behind its deformed wall, an open one closed by caps",
    unit: "m³",
    keys: &[("on", "tag of the wall")],
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
        let facets = site.body.facets(&self.on)?;
        let wall = Wall::cut_by(&site.body.planes, site.space, &facets);
        Ok(Arc::new(Volume::behind(name, wall, Measure::Deformed, None)))
    }
}
