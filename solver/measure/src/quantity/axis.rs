//! A direction, such as that along which a quantity is measured.

use mesh::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A direction as it is written: of any length but 0 [1].
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "[f64; 3]")]
pub struct Axis([f64; 3]);

impl TryFrom<[f64; 3]> for Axis {
    type Error = String;

    fn try_from(axis: [f64; 3]) -> Result<Self, String> {
        match axis.iter().all(|x| x.is_finite()) && axis.iter().any(|x| *x != 0.0) {
            true => Ok(Self(axis)),
            false => Err(format!("{axis:?}: must be a direction, finite and not zero")),
        }
    }
}

impl Axis {
    /// The unit vector along it.
    pub fn unit(&self) -> Vec3 {
        Vec3::from(self.0).normalize()
    }
}
