//! Simulations beside measured tables.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `solver validate` writes to `errors.json`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Validation {
    /// The program that wrote it, with its version.
    pub program: String,
    /// Each simulation beside each measured curve.
    pub rows: Vec<Comparison>,
}

/// A measured point.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredPoint {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Half of the bar around it.
    pub spread: f64,
}

/// A simulation that is an end of a band.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct BandEnd {
    /// Name of the run.
    pub run: String,
    /// Simulated ordinates; null where the simulation has no such state.
    pub simulated: Vec<Option<f64>>,
}

/// A simulation beside measured points.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Name of the row.
    pub row: String,
    /// Name of the run, or of the two runs that are the ends of a band.
    pub run: String,
    /// Whether parameters of it come from these measurements.
    pub fitted: bool,
    /// Measured points.
    pub measured: Vec<MeasuredPoint>,
    /// Simulated ordinates; null where the simulation has no such state. Of a band, what of it is nearest to the
    /// measured one.
    pub simulated: Vec<Option<f64>>,
    /// The two ends of a band; else nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ends: Vec<BandEnd>,
    /// Simulated over measured ordinate − 1, where there is one: the mean [1].
    pub mean: f64,
    /// Root of the mean square of that [1].
    pub rms: f64,
    /// Unit of the ordinate, as its title has it in brackets.
    pub unit: String,
    /// Simulated less measured ordinate, in that unit: the mean.
    pub mean_difference: f64,
    /// Root of the mean square of that.
    pub rms_difference: f64,
    /// Simulated over measured ordinate − 1 of the largest magnitude [1].
    pub largest: f64,
    /// Smallest and largest that are tolerated at any point [1].
    pub tolerance: [f64; 2],
    /// Whether all points are simulated and within the tolerance.
    pub within: bool,
    /// Name of the picture in which it is drawn.
    pub plot: String,
    /// Why this much is tolerated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What is assumed of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub assumed: Option<String>,
    /// Which measurements of the same source were not looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_back: Option<String>,
}

impl Comparison {
    /// What the comparison says.
    pub fn verdict(&self) -> &'static str {
        match (self.fitted, self.within) {
            (true, _) => "fit, no claim",
            (false, true) => "holds",
            (false, false) => "missed",
        }
    }
}
