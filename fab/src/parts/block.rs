//! The block around the part, from which all shells are cut.

use mesh::Vec3;
use mesh::solid::Solid;

use super::key;
use crate::config::Config;
use crate::frame::Pull;

/// A box in the mold's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Lowest corner [m].
    pub min: Vec3,
    /// Highest corner [m].
    pub max: Vec3,
}

impl Block {
    /// The box around a part with the given bounds: `wall` on every side, the
    /// length of the core's stub below, and a band for keys across the pull.
    #[must_use]
    pub fn around((low, high): (Vec3, Vec3), config: &Config, pull: Pull) -> Self {
        let band = config.wall + 2.0 * key::land(&config.keys);
        let along_y = match pull {
            Pull::Z => band,
            // Room beside the parting keys for the base keys under each shell.
            Pull::Y => {
                let needed = 2.0 * (2.0 * key::land(&config.keys) + config.keys.height);
                config.wall.max((needed - (high.y - low.y)) / 2.0)
            }
        };
        let below = config.core.length.max(config.wall);
        Self {
            min: low - Vec3::new(band, along_y, below),
            max: high + Vec3::new(band, along_y, config.wall),
        }
    }

    /// The box as a solid.
    #[must_use]
    pub fn solid(&self) -> Solid {
        Solid::cube(&self.min, &self.max)
    }
}
