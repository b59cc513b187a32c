//! Probes: numbers that are measured at every reported step, as on a test bench.
//!
//! A probe is one number q(u, X, f, r) of a state, with its partial derivatives as a term of an
//! objective has them, so that a design may ask for a value of it (kind `probe` of an
//! `[[objective]]`). One kind per file, with its keys in `[[probe]]`; one row per kind in
//! [`KINDS`].

mod angle;
mod axis;
mod bending;
mod config;
mod contact_force;
mod curvature;
mod displacement;
mod distance;
mod gap;
mod kind;
mod magnitude;
mod means;
mod normal;
mod point;
mod reaction;
#[cfg(test)]
mod tests;
mod volume;

use std::collections::BTreeMap;
use std::sync::Arc;

use mechanics::energy::Iterate;
use mechanics::forward::Problem;

use crate::objective::{Equilibrium, Objective};

pub use config::ProbeConfig;
pub use kind::{COMMON_KEYS, Kind, Site, Specification};

/// All kinds, in the order in which they are listed.
pub const KINDS: &[Kind] = &[
    displacement::KIND,
    magnitude::KIND,
    point::KIND,
    bending::KIND,
    angle::KIND,
    distance::KIND,
    gap::KIND,
    curvature::KIND,
    volume::KIND,
    contact_force::KIND,
    reaction::KIND,
];

/// A probe on a body.
pub struct Probe {
    /// As reports call it.
    pub name: String,
    /// Its row of the table.
    pub kind: &'static Kind,
    /// What it measures.
    pub quantity: Arc<dyn Objective>,
}

/// Values of probes at a state, by their names, in the units of their kinds.
#[must_use]
pub fn measure(probes: &[Probe], problem: &Problem, at: &Iterate) -> BTreeMap<String, f64> {
    let (mut contact, mut reaction) = (Vec::new(), Vec::new());
    if probes.iter().any(|probe| probe.quantity.uses_contact()) {
        contact = problem.energies.contact_forces(at);
    }
    if probes.iter().any(|probe| probe.quantity.uses_reaction()) {
        reaction = problem.gradient(at).0;
    }
    let &Iterate { space, rest, u, load, .. } = at;
    let here = Equilibrium { space, rest, u, load, contact: &contact, reaction: &reaction };
    probes.iter().map(|probe| (probe.name.clone(), probe.quantity.value(&here))).collect()
}
