//! Angle between two tags.
//!
//! q = angle between N₁ and N₂, from 0 to 180°      N = ∫ n da of the deformed tag   [deg]
//!
//! N is the mean normal, out of the body, times the area. A closed surface has none. q has no
//! derivative at 0 and 180°.

use std::sync::Arc;

use anyhow::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Kind, OTHER_TAG, Site, Specification, TAG, form};
use super::normal::Normal;
use crate::objective::{Equilibrium, Measure, Objective};

pub(super) const KIND: Kind = Kind {
    key: "angle",
    formula: "angle between the mean normals of two tags, from 0 to 180",
    unit: "deg",
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
        let sides = [Normal::new(&self.on, site)?, Normal::new(&self.to, site)?];
        Ok(Arc::new(Angle { name: name.to_owned(), sides }))
    }
}

/// The angle between two walls.
struct Angle {
    name: String,
    sides: [Normal; 2],
}

impl Angle {
    /// Adds `weight` ∂q/∂x at the nodes.
    fn add_by_nodes(&self, state: &Equilibrium, weight: f64, out: &mut [f64]) {
        let x = state.nodes(Measure::Deformed);
        let [a, b] = self.sides.each_ref().map(|side| side.at(state.space, &x));
        let Some(across) = a.cross(&b).try_normalize(0.0) else { return };
        let by = [a.cross(&across) / a.norm_squared(), across.cross(&b) / b.norm_squared()];
        for (side, by) in self.sides.iter().zip(by) {
            side.add_by_nodes(state.space, &x, &(weight.to_degrees() * by), out);
        }
    }
}

impl Objective for Angle {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, state: &Equilibrium) -> f64 {
        let x = state.nodes(Measure::Deformed);
        let [a, b] = self.sides.each_ref().map(|side| side.at(state.space, &x));
        a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
    }

    fn add_du(&self, state: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.add_by_nodes(state, weight, out);
    }

    fn add_drest(&self, state: &Equilibrium, weight: f64, out: &mut [f64]) {
        let mut nodal = vec![0.0; 3 * state.space.node_count()];
        self.add_by_nodes(state, weight, &mut nodal);
        state.space.add_to_vertices(&nodal, out);
    }
}
