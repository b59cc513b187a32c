//! Force of contact and friction on a tag or a body along an axis, as in [`ContactForce`]   [N].

use std::sync::Arc;

use anyhow::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::kind::{AXIS, Kind, Site, Specification, form};
use crate::objective::{ContactForce, Objective, Resultant};

pub(super) const KIND: Kind = Kind {
    key: "contact-force",
    formula: "force F of contact and friction on a tag or a body along an axis, a · F",
    unit: "N",
    keys: &[("on", "tag, or one of several bodies"), AXIS],
    needs_contact: true,
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
        let facets = site.body.facets(&self.on)?;
        let nodes = facets.iter().flat_map(|&facet| site.space.facet_nodes(facet)).collect();
        Ok(Arc::new(ContactForce::new(name, nodes, Resultant::Along(self.axis.unit()))))
    }
}
