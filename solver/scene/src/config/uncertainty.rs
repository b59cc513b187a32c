//! `[uncertainty]`: how far numbers of the scene may be off.

use std::collections::BTreeMap;

use anyhow::{Result, bail, ensure};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SimConfig;

/// How far numbers of a scene may be off, each to both sides.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertaintyConfig {
    /// All stresses of all materials, as a part of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modulus: Option<Modulus>,
    /// Position of every wall along its normal [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall: Option<f64>,
    /// Pressure or fill of every chamber [Pa].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
    /// Density of every body, as a part of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Thickness of every membrane, or as well its modulus, as a part of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<f64>,
    /// Coefficient of friction, as a part of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Single numbers of the scene by their paths, as `solver list --numbers` explains them, each in
    /// its unit.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
}

/// How far stresses may be off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a part such as 0.12, or \"sources\"")]
pub enum Modulus {
    /// As a part of them, to both sides.
    Part(f64),
    /// `"sources"`: by the range of all sources of the silicones that the scene names.
    Sources(String),
}

impl UncertaintyConfig {
    /// Checks it against its scene.
    pub fn check(&self, scene: &SimConfig) -> Result<()> {
        let Self { modulus, wall, pressure, density, membrane, friction, numbers: single } = self;
        let part = match modulus {
            Some(Modulus::Part(part)) => Some(*part),
            Some(Modulus::Sources(word)) if word != "sources" => {
                bail!(misfit!(
                    KeyPath::of("modulus"),
                    " = \"{word}\": expected a part such as 0.12, or \"sources\""
                ))
            }
            Some(Modulus::Sources(_)) => {
                let named = |b: &super::BodyConfig| b.material.is_named();
                ensure!(
                    scene.bodies()?.iter().all(named),
                    misfit!(
                        KeyPath::of("modulus"),
                        " = \"sources\": the range of its sources is known of a silicone of \
                     the library only, as material = \"ecoflex-00-30\"; expected a part such as 0.12"
                    )
                );
                None
            }
            None => None,
        };
        let numbers = [
            ("modulus", part),
            ("wall", *wall),
            ("pressure", *pressure),
            ("density", *density),
            ("membrane", *membrane),
            ("friction", *friction),
        ];
        ensure!(
            modulus.is_some()
                || !single.is_empty()
                || numbers.iter().any(|(_, number)| number.is_some()),
            "it is empty; expected one or more of modulus, wall [m], pressure [Pa], density, membrane, \
             friction, numbers"
        );
        for (path, off) in single {
            ensure!(
                off.is_finite() && *off > 0.0,
                misfit!(KeyPath::of("numbers"), ": {path} = {off}: must be positive")
            );
        }
        for (name, number) in numbers.into_iter().filter_map(|(name, n)| Some((name, n?))) {
            let relative = !["wall", "pressure"].contains(&name);
            ensure!(
                number.is_finite() && number > 0.0 && (!relative || number < 1.0),
                misfit!(
                    KeyPath::of(name),
                    " = {number}: must be positive{}",
                    if relative { ", a part of it below 1" } else { "" }
                )
            );
        }
        ensure!(
            !scene.probe.is_empty() || scene.limit.is_some(),
            "there is no [[probe]] and no [limit]: error bars are of these; add a probe for each number that counts"
        );
        ensure!(
            pressure.is_none() || scene.chamber.iter().any(|c| is_pressure(c.gas.key())),
            misfit!(KeyPath::of("pressure"), ": no [[chamber]] has a pressure or fill")
        );
        let weighs = scene.method().has_inertia() || !scene.gravity.is_zero();
        ensure!(
            density.is_none() || weighs,
            misfit!(KeyPath::of("density"), ": the scene has no gravity and no inertia")
        );
        ensure!(
            membrane.is_none() || !scene.membrane.is_empty(),
            misfit!(KeyPath::of("membrane"), ": the scene has no [[membrane]]")
        );
        ensure!(
            friction.is_none() || scene.contact().is_some_and(|c| c.friction > 0.0),
            misfit!(KeyPath::of("friction"), ": there is none in [contact]")
        );
        Ok(())
    }
}

/// Whether a key prescribes a pressure.
pub fn is_pressure(key: &str) -> bool {
    matches!(key, "pressure" | "fill")
}
