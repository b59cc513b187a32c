//! Force of a support on the body.
//!
//! q = a · Σ r_n      over the nodes of a fixed tag, along the axes that it fixes   [N]
//!
//! r = ∂E/∂u on fixed degrees of freedom. A node on the rim of several fixed tags counts
//! for the first of them.

use std::sync::Arc;

use anyhow::{Context as _, Result};
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::kind::{AXIS, Kind, Site, Specification, form};
use crate::objective::{Equilibrium, Objective};

pub(super) const KIND: Kind = Kind {
    key: "reaction",
    formula: "force of a support on the body along an axis, a · Σ r",
    unit: "N",
    keys: &[("on", "tag of a [[fixed]]"), AXIS],
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
        // a tag that does not exist is another error than one that is not fixed
        site.body.facets(&self.on)?;
        let dofs = site.supports.get(&self.on).with_context(|| {
            let fixed: Vec<&str> = site.supports.keys().map(String::as_str).collect();
            format!(
                "on = \"{}\": no [[fixed]] has this tag; fixed are: {}",
                self.on,
                fixed.join(", ")
            )
        })?;
        Ok(Arc::new(Reaction::new(name, dofs.clone(), self.axis.unit())))
    }
}

/// Sum of the forces on fixed degrees of freedom along an axis.
struct Reaction {
    name: String,
    dofs: Vec<usize>,
    axis: Vec3,
}

impl Reaction {
    fn new(name: &str, dofs: Vec<usize>, axis: Vec3) -> Self {
        Self { name: name.to_owned(), dofs, axis }
    }
}

impl Objective for Reaction {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.dofs.iter().map(|&dof| self.axis[dof % 3] * at.reaction[dof]).sum()
    }

    fn add_du(&self, _: &Equilibrium, _: f64, _: &mut [f64]) {}

    fn uses_reaction(&self) -> bool {
        true
    }

    fn add_dreaction(&self, _: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.dofs.iter().for_each(|&dof| out[dof] += weight * self.axis[dof % 3]);
    }

    fn add_drest(&self, _: &Equilibrium, _: f64, _: &mut [f64]) {}
}
