//! `[uncertainty]`: how far numbers of the scene may be off.

use std::collections::BTreeMap;

use anyhow::{Result, ensure};
use program::table::{Numbers, Range, named};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SimConfig;

program::table! {
    /// How far numbers of a scene may be off, each to both sides.
    #[derive(Clone, Debug)]
    pub struct UncertaintyConfig {
        /// All stresses of all materials, as a part of them.
        modulus: Option<Modulus> = None, PART;
        /// Position of every wall along its normal [m].
        wall: Option<f64> = None, Range::POSITIVE.unit("m");
        /// Pressure or fill of every chamber [Pa].
        pressure: Option<f64> = None, Range::POSITIVE.unit("Pa");
        /// Density of every body, as a part of it.
        density: Option<f64> = None, PART;
        /// Thickness of every membrane, or as well its modulus, as a part of it.
        membrane: Option<f64> = None, PART;
        /// Coefficient of friction, as a part of it.
        friction: Option<f64> = None, PART;
        /// Single numbers of the scene by their paths, as `solver list --numbers` explains them, each in
        /// its unit.
        numbers: BTreeMap<String, f64> = BTreeMap::new(), named::<f64>(Range::POSITIVE);
    }
}

/// A part of a number.
const PART: Range = Range::above(0.0).below(1.0).advice(", a part of it");

/// How far stresses may be off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a part such as 0.12, or \"sources\"")]
pub enum Modulus {
    /// As a part of them, to both sides.
    Part(f64),
    /// By the range of all sources of the silicones that the scene names.
    Sources(Sources),
}

/// The word in place of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sources {
    /// By the range of all sources of the silicones that the scene names.
    Sources,
}

impl Numbers for Modulus {
    fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Part(part) => vec![*part],
            Self::Sources(_) => Vec::new(),
        }
    }
}

impl UncertaintyConfig {
    /// Checks it against its scene.
    pub fn check(&self, scene: &SimConfig) -> Result<()> {
        let Self { modulus, wall, pressure, density, membrane, friction, numbers } = self;
        let named = |body: &super::BodyConfig| body.material.is_named();
        ensure!(
            !matches!(modulus, Some(Modulus::Sources(_))) || scene.bodies()?.iter().all(named),
            misfit!(
                KeyPath::of("modulus"),
                " = \"sources\": the range of its sources is known of a silicone of the library only, as \
                 material = \"ecoflex-00-30\"; expected a part such as 0.12"
            )
        );
        let single = [wall, pressure, density, membrane, friction];
        ensure!(
            modulus.is_some()
                || !numbers.is_empty()
                || single.iter().any(|number| number.is_some()),
            "it is empty; expected one or more of modulus, wall [m], pressure [Pa], density, membrane, \
             friction, numbers"
        );
        ensure!(
            !scene.probe.is_empty() || scene.limit.is_some(),
            "there is no [[probe]] and no [limit]: error bars are of these; add a probe for each number that counts"
        );
        let has_pressure = scene.chamber.iter().any(|chamber| chamber.gas.is_pressure());
        let weighs = scene.method().has_inertia() || !scene.gravity.is_zero();
        let rubs = scene.contact().is_some_and(|contact| contact.friction > 0.0);
        for (key, given, has, what) in [
            ("pressure", pressure, has_pressure, "no [[chamber]] has a pressure or fill"),
            ("density", density, weighs, "the scene has no gravity and no inertia"),
            ("membrane", membrane, !scene.membrane.is_empty(), "the scene has no [[membrane]]"),
            ("friction", friction, rubs, "there is none in [contact]"),
        ] {
            ensure!(given.is_none() || has, misfit!(KeyPath::of(key), ": {what}"));
        }
        Ok(())
    }
}
