//! `[[constraint]]` of the end of a run: a probe of the scene, or the slope of the pressure, stays within bounds.

use anyhow::{Result, ensure};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bounds of a probe, in its unit.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeBound {
    /// As reports call it.
    pub(crate) name: String,
    /// Name of a probe of the scene.
    pub probe: String,
    /// The smallest value that the probe may have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// The largest value that the probe may have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
}

impl ProbeBound {
    pub(crate) fn check(&self) -> Result<()> {
        let Self { least, most, .. } = self;
        ensure!(
            least.is_some() || most.is_some(),
            misfit!(
                KeyPath::of("probe"),
                ": without least and most nothing is kept; expected one of them, or both"
            )
        );
        let [low, high] = [least.unwrap_or(f64::NEG_INFINITY), most.unwrap_or(f64::INFINITY)];
        ensure!(
            low < high && least.is_none_or(f64::is_finite) && most.is_none_or(f64::is_finite),
            misfit!(
                KeyPath::of("least"),
                " = {low} and most = {high}: expected numbers, least below most"
            )
        );
        Ok(())
    }
}

/// The least slope of the pressure by the volume, over pressure by change of volume from rest: 1 where the body answers in
/// proportion, 0 where it balloons.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlopeBound {
    /// As reports call it.
    pub(crate) name: String,
    /// The smallest slope [1].
    pub least: f64,
}

impl SlopeBound {
    pub(crate) fn check(&self) -> Result<()> {
        ensure!(
            self.least.is_finite() && self.least > 0.0,
            misfit!(
                KeyPath::of("least"),
                " = {}: must be above 0, the slope where it balloons",
                self.least
            )
        );
        Ok(())
    }
}
