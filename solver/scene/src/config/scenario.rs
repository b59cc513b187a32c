//! `[[scenario]]` and `[robust]`: cases that one design must be good in, and how their
//! objectives become one.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::level::check_weights;

/// Name of the term that the objectives of scenarios are more than their mean by.
pub const EXCESS: &str = "excess";

/// A case that the design is simulated in. What is left out is as the scene has it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScenarioConfig {
    /// What histories call it.
    pub name: String,
    /// How much it counts beside the others [1].
    #[serde(default = "one")]
    pub weight: f64,
    /// Every wall outward along its normal, or those with tags [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall: Option<WallConfig>,
    /// Factor on all stresses of all materials, or of those of volumes or bodies by name [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modulus: Option<FactorConfig>,
    /// Factor on the density of every body, or of volumes or bodies by name [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<FactorConfig>,
    /// Factor on the thickness of every membrane, or as well on its modulus; or of those on tags [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<FactorConfig>,
    /// Factor on the coefficient of friction [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Added to the pressure or fill of every chamber [Pa].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
    /// Values of numbers of the scene by their paths, as `solver list --numbers` explains them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
    /// Values in place of the scene's `[parameters]`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// Factors on the weights of objectives, by their names; 1 for the others.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub weights: BTreeMap<String, f64>,
}

/// `wall` of a scenario [m].
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a distance [m], or a table with one for each tag")]
pub enum WallConfig {
    /// All.
    All(f64),
    /// Those with tags.
    Tags(BTreeMap<String, f64>),
}

/// A factor of a scenario [1].
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a factor, or a table with one for each name")]
pub enum FactorConfig {
    /// On all.
    All(f64),
    /// On those with names; 1 on the others.
    Named(BTreeMap<String, f64>),
}

impl FactorConfig {
    /// Each factor with the name that it is on; none for all.
    pub fn each(&self) -> Vec<(Option<&str>, f64)> {
        match self {
            Self::All(factor) => vec![(None, *factor)],
            Self::Named(factors) => {
                factors.iter().map(|(name, factor)| (Some(name.as_str()), *factor)).collect()
            }
        }
    }
}

/// One objective from those of the scenarios: their mean without this table.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobustConfig {
    /// Standard deviations that are added to the mean [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviations: Option<f64>,
    /// The largest in place of the mean, smoothed over this difference [unit of the objective].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst: Option<f64>,
}

fn one() -> f64 {
    1.0
}

impl Default for ScenarioConfig {
    /// The scene as it is.
    fn default() -> Self {
        Self {
            name: String::new(),
            weight: one(),
            wall: None,
            modulus: None,
            density: None,
            membrane: None,
            friction: None,
            pressure: None,
            numbers: BTreeMap::new(),
            parameters: BTreeMap::new(),
            weights: BTreeMap::new(),
        }
    }
}

impl ScenarioConfig {
    /// What messages call it; none where a design has no scenarios.
    pub fn title(&self) -> Option<String> {
        (!self.name.is_empty()).then(|| format!("scenario \"{}\"", self.name))
    }

    /// How far each wall is off: the tag, or none for all, and the distance [m].
    pub fn walls(&self) -> Vec<(Option<&str>, f64)> {
        match &self.wall {
            None => Vec::new(),
            Some(WallConfig::All(distance)) => vec![(None, *distance)],
            Some(WallConfig::Tags(tags)) => {
                tags.iter().map(|(tag, distance)| (Some(tag.as_str()), *distance)).collect()
            }
        }
    }

    /// Whether it makes sense, outside of a design.
    pub fn check_alone(&self) -> Result<()> {
        let weighted: Vec<&str> = self.weights.keys().map(String::as_str).collect();
        self.check(&weighted, &[])
    }

    fn check(&self, objectives: &[&str], designed: &[&str]) -> Result<()> {
        let Self { weight, modulus, density, membrane, friction, pressure, .. } = self;
        let named = [("modulus", modulus), ("density", density), ("membrane", membrane)];
        for (key, factors) in named {
            ensure!(
                factors.as_ref().is_none_or(|factors| !factors.each().is_empty()),
                misfit!(
                    KeyPath::of(key),
                    " = {{}}: expected a factor, or one for each of some names"
                )
            );
            for (name, factor) in factors.iter().flat_map(FactorConfig::each) {
                let title = name.map_or_else(|| key.to_owned(), |name| format!("{key} of {name}"));
                check_factor(&title, factor)?;
            }
        }
        for (key, factor) in friction.iter().map(|&f| ("friction", f)).chain([("weight", *weight)])
        {
            check_factor(key, factor)?;
        }
        let pressure = pressure.iter().map(|&difference| ("pressure", difference));
        let walls =
            self.walls().into_iter().map(|(tag, distance)| (tag.unwrap_or("wall"), distance));
        for (key, number) in pressure.chain(walls) {
            ensure!(number.is_finite(), misfit!(KeyPath::of(key), " = {number}: must be finite"));
        }
        for (path, value) in &self.numbers {
            ensure!(
                value.is_finite(),
                misfit!(KeyPath::of("numbers"), ": {path} = {value}: must be finite")
            );
        }
        for name in self.parameters.keys() {
            ensure!(
                !designed.contains(&name.as_str()),
                misfit!(
                    KeyPath::of("parameters"),
                    ": {name} is a [[parameter]] of the design; expected one of them"
                )
            );
        }
        check_weights(&self.weights, objectives)
    }
}

fn check_factor(title: &str, factor: f64) -> Result<()> {
    ensure!(
        factor.is_finite() && factor > 0.0,
        misfit!(KeyPath::of(title), " = {factor}: must be positive")
    );
    Ok(())
}

/// Checks the scenarios of a design with these objectives and designed parameters.
pub(super) fn check(
    scenarios: &[ScenarioConfig],
    robust: Option<RobustConfig>,
    objectives: &[&str],
    designed: &[&str],
) -> Result<()> {
    for (i, scenario) in scenarios.iter().enumerate() {
        let name = misfit!(KeyPath::list("scenario"), " without a name; expected name = \"…\"");
        ensure!(!scenario.name.is_empty(), name);
        let title = KeyPath::list("scenario").named(&scenario.name);
        let twice = scenarios[..i].iter().any(|other| other.name == scenario.name);
        ensure!(!twice, misfit!(title, " is given twice; expected names that differ"));
        scenario.check(objectives, designed).context(title)?;
    }
    let Some(RobustConfig { deviations, worst }) = robust else { return Ok(()) };
    let robust = KeyPath::table("robust");
    ensure!(
        scenarios.len() > 1,
        misfit!(
            robust,
            " with {} [[scenario]]; expected two or more, of which it makes one objective",
            scenarios.len()
        )
    );
    ensure!(
        !objectives.contains(&EXCESS),
        misfit!(
            KeyPath::list("objective").named(EXCESS),
            " beside [robust], whose term has this name; expected another"
        )
    );
    ensure!(
        deviations.is_some() != worst.is_some(),
        misfit!(robust, ": expected deviations or worst, one of them")
    );
    if let Some(deviations) = deviations {
        ensure!(
            deviations.is_finite() && deviations >= 0.0,
            robust
                .key("deviations")
                .told(format!("[robust] deviations = {deviations}: must not be negative"))
        );
    }
    if let Some(worst) = worst {
        ensure!(
            worst.is_finite() && worst > 0.0,
            robust.key("worst").told(format!(
                "[robust] worst = {worst}: must be positive; differences of the objective below it do \
                 not count"
            ))
        );
    }
    Ok(())
}
