//! `[[objective]]`: a quantity that a design minimises, with a weight and a sum over time.

mod time_integral;

use std::path::Path;

use anyhow::{Result, ensure};
use program::{KeyPath, Misfit, misfit};
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::entry::{Common, Entry};
use crate::kinds;
use crate::quantity::List;

pub use time_integral::TimeIntegral;

/// A weighted term of the objective.
pub type ObjectiveConfig = Entry<ObjectiveKeys>;

/// How much a term counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// Factor of its value, in the inverse of its unit.
    Factor(f64),
    /// The part of the objective that it is at the start, negative where it is maximised [1].
    Share(f64),
}

/// The keys of all objectives.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ObjectiveConfig")]
pub struct ObjectiveKeys {
    /// as reports call it
    name: String,
    /// of the value, in the inverse of its unit
    #[serde(skip_serializing_if = "Option::is_none")]
    weight: Option<f64>,
    /// in place of weight: the part of the objective that the term is at the start
    #[serde(skip_serializing_if = "Option::is_none")]
    share: Option<f64>,
    /// the time: "final", { steps = [2, 5] } or { times = [0.4, 1.0] } for their mean, or
    /// a sum [s]: "uniform", "trapezoid", "simpson"
    #[serde(default)]
    over: TimeIntegral,
}

impl Common for ObjectiveKeys {
    const LIST: List = List::Objective;

    fn name(&self) -> &str {
        &self.name
    }

    fn complete(&self) -> Result<(), Misfit> {
        match self.weight.is_some() != self.share.is_some() {
            true => Ok(()),
            false => Err(KeyPath::default().told("expected one of weight = ... and share = ...")),
        }
    }

    fn check(&self, may_be_maximised: bool) -> Result<()> {
        let (key, value) = match self.weight() {
            Weight::Factor(weight) => ("weight", weight),
            Weight::Share(share) => ("share", share),
        };
        ensure!(
            value.is_finite(),
            misfit!(KeyPath::of(key), " = {value}: must be a finite number")
        );
        ensure!(
            value >= 0.0 || may_be_maximised,
            misfit!(
                KeyPath::of(key),
                " = {value}: a negative {key} maximises a term, which makes sense for {} only",
                maximised()
            )
        );
        ensure!(
            key == "weight" || value != 0.0 && value.abs() <= 1.0,
            misfit!(KeyPath::of(key), " = {value}: must be a part of the objective, up to 1")
        );
        Ok(())
    }

    fn describe(schema: &mut Schema) {
        let needs = |key: &str| json!({ "required": [key] });
        schema.insert("if".into(), needs("share"));
        schema.insert("then".into(), json!({ "not": needs("weight") }));
        schema.insert("else".into(), needs("weight"));
    }
}

impl ObjectiveKeys {
    fn weight(&self) -> Weight {
        match (self.share, self.weight) {
            (Some(share), _) => Weight::Share(share),
            (None, weight) => Weight::Factor(weight.unwrap_or_default()),
        }
    }
}

impl ObjectiveConfig {
    /// How much it counts.
    pub fn weight(&self) -> Weight {
        self.common.weight()
    }

    /// Whether it is minimised and no linear function of what it looks at, which has no curvature.
    pub fn is_square(&self) -> bool {
        let may_be_maximised = self.kind().may_be_maximised && self.own.may_be_maximised();
        let (Weight::Factor(size) | Weight::Share(size)) = self.weight();
        !may_be_maximised && size >= 0.0
    }

    /// What it is summed over.
    pub fn over(&self) -> &TimeIntegral {
        &self.common.over
    }

    /// The probe that it looks at, and the number that it wants of it, in the unit of the probe, if it names one.
    pub fn probe(&self) -> Option<(&str, Option<f64>)> {
        let number =
            |value: &toml::Value| value.as_float().or(value.as_integer().map(|n| n as f64));
        let name = self.keys.get("probe")?.as_str()?;
        Some((name, self.keys.get("target").and_then(number)))
    }

    /// The files that it names, from the folder of the design.
    pub fn files(&self) -> Vec<&Path> {
        self.own.files()
    }
}

/// Checks that the shares of some objectives leave what the weights of the others need.
pub fn check_shares(objectives: &[ObjectiveConfig]) -> Result<()> {
    let (mut sum, mut shares, mut weighted) = (0.0, false, false);
    for objective in objectives {
        match objective.weight() {
            Weight::Share(share) => (sum, shares) = (sum + share.abs(), true),
            Weight::Factor(factor) => weighted |= factor != 0.0,
        }
    }
    ensure!(
        !shares || !weighted || sum < 1.0,
        misfit!(
            KeyPath::list("objective"),
            ": the shares come to {sum:.3}, which leaves nothing for the objectives with a weight: they must \
             be less than 1 in all"
        )
    );
    ensure!(
        !shares || weighted || (sum - 1.0).abs() < 1e-9,
        misfit!(
            KeyPath::list("objective"),
            ": the shares come to {sum:.3}: they must be 1 in all where no objective has a weight"
        )
    );
    Ok(())
}

/// Kinds whose weight may be negative, for messages.
fn maximised() -> String {
    let kinds = kinds::of(List::Objective).filter(|kind| kind.may_be_maximised);
    let kinds = kinds.map(|kind| kind.key);
    kinds.collect::<Vec<_>>().join(", ") + " (without a wanted one)"
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
