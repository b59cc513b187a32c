//! `[[scenario]]` and `[robust]`: cases that one design must be good in, and how their
//! objectives become one.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use program::table::{Range, Rule, Table, named};
use program::{KeyPath, Misfit, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::level::check_weights;

/// Name of the term that the objectives of scenarios are more than their mean by.
pub const EXCESS: &str = "excess";

program::table! {
    /// A case that the design is simulated in. What is left out is as the scene has it.
    #[derive(Clone, Debug)]
    pub struct ScenarioConfig {
        /// What histories call it.
        name: String;
        /// How much it counts beside the others [1].
        weight: f64 = 1.0, Range::POSITIVE;
        /// Every wall outward along its normal, or those with tags [m].
        wall: Option<ByName> = None, each_is(Range::FINITE.unit("m"));
        /// Factor on all stresses of all materials, or of those of volumes or bodies by name [1].
        modulus: Option<ByName> = None, each_is(Range::POSITIVE);
        /// Factor on the density of every body, or of volumes or bodies by name [1].
        density: Option<ByName> = None, each_is(Range::POSITIVE);
        /// Factor on the thickness of every membrane, or as well on its modulus; or of those on tags [1].
        membrane: Option<ByName> = None, each_is(Range::POSITIVE);
        /// Factor on the coefficient of friction [1].
        friction: Option<f64> = None, Range::POSITIVE;
        /// Added to the pressure or fill of every chamber [Pa].
        pressure: Option<f64> = None, Range::FINITE.unit("Pa");
        /// Values of numbers of the scene by their paths, as `solver list --numbers` explains them.
        numbers: BTreeMap<String, f64> = BTreeMap::new(), named::<f64>(Range::FINITE);
        /// Values in place of the scene's `[parameters]`.
        parameters: BTreeMap<String, f64> = BTreeMap::new();
        /// Factors on the weights of objectives, by their names; 1 for the others.
        weights: BTreeMap<String, f64> = BTreeMap::new(), named::<f64>(Range::NOT_NEGATIVE);
    }
}

/// One number for all, or several by the names of what they are for.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number, or a table with one for each name")]
pub enum ByName {
    /// For all.
    All(f64),
    /// For those with names.
    Named(BTreeMap<String, f64>),
}

impl ByName {
    /// Each number with the name that it is for; none for all.
    pub fn each(&self) -> Vec<(Option<&str>, f64)> {
        match self {
            Self::All(number) => vec![(None, *number)],
            Self::Named(numbers) => {
                numbers.iter().map(|(name, number)| (Some(name.as_str()), *number)).collect()
            }
        }
    }
}

/// The rule of numbers that are in a range, one or more.
fn each_is(range: Range) -> impl Fn(&KeyPath, &Option<ByName>) -> Result<(), Misfit> {
    move |at, numbers| match numbers {
        None => Ok(()),
        Some(ByName::All(number)) => range.admit(at, *number),
        Some(ByName::Named(numbers)) if numbers.is_empty() => {
            Err(misfit!(at.clone(), " = {{}}: expected a number, or one for each of some names"))
        }
        Some(ByName::Named(numbers)) => named::<f64>(range).check(at, numbers),
    }
}

program::table! {
    /// One objective from those of the scenarios: their mean without this table.
    #[derive(Clone, Copy, Debug)]
    pub struct RobustConfig {
        /// Standard deviations that are added to the mean [1].
        deviations: Option<f64> = None, Range::NOT_NEGATIVE;
        /// The largest in place of the mean, smoothed over this difference [unit of the objective].
        worst: Option<f64> = None, Range::POSITIVE.advice("; differences of the objective below it do not count");
    }
}

impl Default for ScenarioConfig {
    /// The scene as it is.
    fn default() -> Self {
        toml::from_str("name = ''").expect("all else has a default")
    }
}

impl ScenarioConfig {
    /// What messages call it; none where a design has no scenarios.
    pub fn title(&self) -> Option<String> {
        (!self.name.is_empty()).then(|| format!("scenario \"{}\"", self.name))
    }

    /// How far each wall is off: the tag, or none for all, and the distance [m].
    pub fn walls(&self) -> Vec<(Option<&str>, f64)> {
        self.wall.iter().flat_map(ByName::each).collect()
    }

    /// Whether it makes sense, outside of a design.
    pub fn check_alone(&self) -> Result<()> {
        Ok(self.check_ranges(&KeyPath::default())?)
    }

    fn check(&self, objectives: &[&str], designed: &[&str]) -> Result<()> {
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
    Ok(())
}
