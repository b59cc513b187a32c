//! A probe of the scene, or what is left to a wanted value of it.
//!
//! J = q / s                 [1]
//! J = ((q − q*(t)) / s)²    [1]
//!
//! q    value of the probe, in its unit; q* the wanted one, as it is written, from t = 0 on
//! s    scale: a difference that counts as 1

use crate::written::ScheduleSchema;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow, ensure};
use mechanics::schedule::Schedule;
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{Builder, Kind, Specification, form};
use super::{Equilibrium, Objective};

pub(super) const KIND: Kind = Kind {
    key: "probe",
    formula: "q/s, or ((q − q*)/s)², q the value of a probe of the scene",
    unit: "1",
    keys: &[
        ("probe", "its name"),
        ("target", "q*, in the unit of the probe: a number, an expression in t, or a table"),
        ("scale", "s, in the unit of the probe (1)"),
    ],
    may_be_maximised: true,
    needs_contact: false,
    form: form::<Keys>(),
};

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    probe: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<ScheduleSchema>")]
    target: Option<Schedule>,
    #[serde(default = "one")]
    scale: f64,
}

fn one() -> f64 {
    1.0
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        ensure!(
            self.scale.is_finite() && self.scale > 0.0,
            "scale = {}: must be positive, in the unit of the probe",
            self.scale
        );
        if let Some(target) = &self.target {
            let bound = target.clone().bind(&BTreeMap::new());
            bound.map_err(|what| anyhow!("target: {what}"))?;
            ensure!(!target.uses_position(), "target = {target}: must depend on t alone");
        }
        Ok(())
    }

    fn may_be_maximised(&self) -> bool {
        self.target.is_none()
    }

    fn prepare(&self, _: &Path) -> Result<Builder> {
        let Self { probe, target, scale } = self.clone();
        Ok(Box::new(move |name, bodies| {
            let quantity = bodies.probes.get(&probe).with_context(|| {
                let known: Vec<&str> = bodies.probes.keys().map(String::as_str).collect();
                format!(
                    "probe = \"{probe}\": no [[probe]] of the scene is called that; there are: {}",
                    known.join(", ")
                )
            })?;
            if let Some(target) = &target {
                target.check(bodies.times, &[]).map_err(|what| anyhow!("target: {what}"))?;
            }
            let (quantity, target) = (Arc::clone(quantity), target.clone());
            Ok(Box::new(ProbeTarget { name: name.to_owned(), quantity, target, scale }))
        }))
    }
}

/// A probe over its scale, or the square of what is left to a wanted value.
struct ProbeTarget {
    name: String,
    quantity: Arc<dyn Objective>,
    target: Option<Schedule>,
    scale: f64,
}

impl ProbeTarget {
    /// J, with ∂J/∂q.
    fn at(&self, state: &Equilibrium) -> (f64, f64) {
        let q = self.quantity.value(state);
        let Some(target) = &self.target else { return (q / self.scale, 1.0 / self.scale) };
        let left = (q - target.as_written(Vec3::zeros(), state.load).value) / self.scale;
        (left * left, 2.0 * left / self.scale)
    }
}

impl Objective for ProbeTarget {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.at(at).0
    }

    fn add_du(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.quantity.add_du(at, weight * self.at(at).1, out);
    }

    fn uses_contact(&self) -> bool {
        self.quantity.uses_contact()
    }

    fn add_dcontact(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.quantity.add_dcontact(at, weight * self.at(at).1, out);
    }

    fn uses_reaction(&self) -> bool {
        self.quantity.uses_reaction()
    }

    fn add_dreaction(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.quantity.add_dreaction(at, weight * self.at(at).1, out);
    }

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.quantity.add_drest(at, weight * self.at(at).1, out);
    }
}
