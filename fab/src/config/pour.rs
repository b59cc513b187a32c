//! `[sprue]` and `[vents]`: how silicone gets in and air out.

use serde::Deserialize;

/// The conical sprue.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sprue {
    /// A point of the design above or below which the sprue enters. Unset: the highest point [m].
    pub at: Option<[f64; 3]>,
    /// Radius at the part [m].
    pub radius: f64,
    /// Radius at the top of the mold [m].
    pub top_radius: f64,
    /// Share of the body that a funnel in the sprue holds. Unset: no funnel [1].
    pub head: Option<f64>,
}

impl Default for Sprue {
    fn default() -> Self {
        Self { at: None, radius: 3e-3, top_radius: 5.4e-3, head: None }
    }
}

impl Sprue {
    /// Whether the funnel can be.
    ///
    /// # Errors
    /// The key, what it is, and what it may be.
    pub fn check(&self) -> Result<(), String> {
        match self.head {
            Some(head) if !(head > 0.0 && head <= 1.0) => Err(format!(
                "sprue.head is {head}, must be a share of the body above 0 and at most 1"
            )),
            _ => Ok(()),
        }
    }
}

/// Vents at the local maxima of height.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Vents {
    /// Radius of a vent [m].
    pub radius: f64,
    /// A maximum is vented if one has to descend at least this far to reach a higher one [m].
    pub persistence: f64,
}

impl Default for Vents {
    fn default() -> Self {
        Self { radius: 8e-4, persistence: 1e-3 }
    }
}
