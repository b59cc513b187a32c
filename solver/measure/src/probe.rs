//! `[[probe]]`: a quantity that is measured at every reported step, as on a test bench.

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::{Result, ensure};
use mechanics::energy::Iterate;
use mechanics::forward::Problem;
use program::KeyPath;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::entry::{Common, Entry};
use crate::quantity::{Equilibrium, Forces, Kind, List, Quantity};

/// A probe of a scene.
pub type ProbeConfig = Entry<ProbeKeys>;

/// The keys of all probes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ProbeConfig")]
pub struct ProbeKeys {
    /// its column in results
    name: String,
}

impl Common for ProbeKeys {
    const LIST: List = List::Probe;

    fn name(&self) -> &str {
        &self.name
    }

    fn check(&self, _: bool) -> Result<()> {
        // `solver plot` separates columns by commas and factors by stars
        let sound = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
        ensure!(
            !self.name.is_empty() && self.name.chars().all(sound),
            KeyPath::of("name")
                .told("a name has letters, digits, _ and -, and one of them or more")
        );
        Ok(())
    }
}

/// A probe on a body.
pub struct Probe {
    /// As reports call it.
    pub name: String,
    /// The row of the table.
    pub kind: &'static Kind,
    /// What it measures.
    pub quantity: Arc<dyn Quantity>,
}

/// Values of probes at a state, by their names, in the units of their kinds.
pub fn measure(probes: &[Probe], problem: &Problem, at: &Iterate) -> BTreeMap<String, f64> {
    let mut forces = Forces::default();
    if probes.iter().any(|probe| probe.quantity.uses_contact()) {
        forces.contact = problem.energies.contact_forces(at);
    }
    if probes.iter().any(|probe| probe.quantity.uses_reaction()) {
        forces.reaction = problem.gradient(at).0;
    }
    let here = Equilibrium::new(problem, at, &forces);
    probes.iter().map(|probe| (probe.name.clone(), probe.quantity.value(&here))).collect()
}
