//! The direction along which a probe measures.

use anyhow::{Result, ensure};
use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `axis` as it is written: of any length but 0 [1].
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Axis([f64; 3]);

impl Axis {
    /// Whether it has a direction.
    ///
    /// # Errors
    /// When it is zero or not finite.
    pub fn check(&self) -> Result<()> {
        ensure!(
            self.0.iter().all(|x| x.is_finite()) && self.0.iter().any(|x| *x != 0.0),
            "axis = {:?}: must be finite, and not zero",
            self.0
        );
        Ok(())
    }

    /// The unit vector along it.
    #[must_use]
    pub fn unit(&self) -> Vec3 {
        Vec3::from(self.0).normalize()
    }
}
