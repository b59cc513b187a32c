//! Softening after a first stretch, as reports have it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::numbers::Numbers;

/// How far a body or volume with `[[mullins]]` is softened.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Mullins {
    /// The body or volume.
    pub on: String,
    /// Largest isochoric energy density that a point has had, W_m [J/m³].
    pub largest_energy: f64,
    /// Smallest factor η on the isochoric stress in this state [1].
    pub factor: f64,
    /// Smallest η at rest after it, where the next inflation begins [1].
    pub factor_at_rest: f64,
    /// Mean of η at rest over the volume [1].
    pub mean_factor_at_rest: f64,
    /// Work that softening has taken by the time the body is at rest again [J].
    pub lost: f64,
}

/// A largest pressure of a chamber between two smaller ones, or at the end of the run.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Inflation {
    /// The chamber, by the tag of its wall.
    pub chamber: String,
    /// Which of its inflations, counted from 1.
    pub number: usize,
    /// At the largest pressure.
    pub peak: Inflated,
    /// At half of it on the way up, along a line between two steps; not where one step goes beyond it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub halfway: Option<Inflated>,
}

/// A state of an inflation.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Inflated {
    /// Time [s].
    pub t: f64,
    /// Gauge pressure [Pa].
    pub pressure: f64,
    /// Volume [m³].
    pub volume: f64,
    /// Value of each probe, in its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<Numbers>,
}
