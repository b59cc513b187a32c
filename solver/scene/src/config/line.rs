//! Lines in space and directions, as tables give them.

use anyhow::{Result, ensure};
use mechanics::energy::Axis;
use mesh::Vec3;
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A line in space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AroundConfig {
    /// A point on it [m].
    pub point: [f64; 3],
    /// A vector along it, of any length.
    pub axis: [f64; 3],
}

impl AroundConfig {
    /// The line that is the key `around` of a table.
    pub fn line(&self, title: &KeyPath) -> Result<Axis> {
        self.line_at(&title.clone().key("around"))
    }

    /// The line at a key.
    pub(super) fn line_at(&self, key: &KeyPath) -> Result<Axis> {
        let along = unit(self.axis, &key.clone().key("axis"))?;
        ensure!(
            self.point.iter().all(|x| x.is_finite()),
            misfit!(key.clone().key("point"), " = {:?} m: must be finite", self.point)
        );
        Ok(Axis { point: self.point.into(), along })
    }
}

/// The unit vector along a vector.
pub(super) fn unit(vector: [f64; 3], key: &KeyPath) -> Result<Vec3> {
    let length = Vec3::from(vector).norm();
    ensure!(
        length > 0.0 && length.is_finite(),
        misfit!(
            key.clone(),
            " = {vector:?}: no direction; expected a vector of a positive, finite length"
        )
    );
    Ok(Vec3::from(vector) / length)
}
