//! `[[parameter]]` of a design: a number of the scene that may change.

use anyhow::{Result, ensure};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number of the scene that may change, such as a peak pressure or a delay.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterDesign {
    /// The name in the scene's `[parameters]`, or the path of a number of `solver list --numbers`.
    pub name: String,
    /// Smallest and largest value.
    pub bounds: [f64; 2],
    /// Largest change in one iteration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change: Option<f64>,
    /// Keeps it small: `small × (value / scale)²` is a term of the objective with its name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub small: Option<f64>,
    /// The value that counts as `small`; the larger of the bounds if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
}

impl ParameterDesign {
    /// The value at which the term that keeps the parameter small is 1: scale / √small; none without `small`.
    pub fn unit_cost(&self) -> Option<f64> {
        let largest = self.bounds.iter().fold(0.0, |most: f64, bound| most.max(bound.abs()));
        Some(self.scale.unwrap_or(largest) / self.small?.sqrt())
    }

    pub(super) fn check(&self) -> Result<()> {
        let Self { name, bounds: [low, high], change, small, scale } = self;
        let title = KeyPath::list("parameter").named(name);
        ensure!(
            low < high && low.is_finite() && high.is_finite(),
            misfit!(
                title.key("bounds"),
                " = [{low}, {high}]; expected two numbers, the smaller first"
            )
        );
        for (key, value) in [("change", change), ("small", small), ("scale", scale)] {
            ensure!(
                value.is_none_or(|value| value.is_finite() && value > 0.0),
                misfit!(
                    title.clone().key(key),
                    " = {:?} must be positive",
                    value.unwrap_or(f64::NAN)
                )
            );
        }
        ensure!(
            scale.is_none() || small.is_some(),
            misfit!(title.key("scale"), " without small: expected small = 1.0, its weight")
        );
        Ok(())
    }
}
