//! The bounds of a closed mold.

use geometry::frame::Pull;
use mesh::Vec3;
use mesh::solid::Solid;

use super::flange::Joint;
use super::key::Sizes;
use crate::body::orientation::{Orientation, PartingSurface, Portion};
use crate::config::Config;

/// A box in the mold's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Lowest corner [m].
    pub min: Vec3,
    /// Highest corner [m].
    pub max: Vec3,
}

impl Block {
    /// The box around a part with the given bounds: `wall` on every side, at both
    /// ends of x a band for keys and bolts, below the part what its core needs, and above the
    /// height `joint` of sides that replace an upper shell, if there are any, what these need [m].
    pub fn around(
        (low, high): (Vec3, Vec3),
        orientation: &Orientation,
        pull: Pull,
        joint: Option<f64>,
        config: &Config,
    ) -> Self {
        let wall = config.wall;
        if matches!(orientation.parting, PartingSurface::Open) {
            return Self {
                min: low - Vec3::repeat(wall),
                max: Vec3::new(high.x + wall, high.y + wall, high.z),
            };
        }
        let land = Sizes::of(config).land();
        let needed = match pull {
            Pull::Z => 4.0 * land,
            // Room beside the flange of the shells for the keys of the base.
            Pull::Y => 4.0 * land + 2.0 * config.flange.thickness,
        };
        let rim = match (&orientation.parting, pull) {
            (PartingSurface::HeightField(_), Pull::Z) => wall + Self::rim(config),
            _ => wall,
        };
        let along_y = rim.max((needed - (high.y - low.y)) / 2.0);
        let tall = match pull {
            Pull::Z => 0.0,
            Pull::Y => Self::sides(config),
        };
        let above = wall.max(tall - (high.z - low.z));
        // Bolts between base and sides stand beside their keys, where nothing is above them.
        let beside = match (&orientation.parting, pull) {
            (PartingSurface::Seat, _) | (_, Pull::Z) => 0.0,
            (_, Pull::Y) => Joint::washer(config),
        };
        let along_x = wall + Joint::band(config) + beside;
        let mut max = high + Vec3::new(along_x, along_y, above);
        if let Some(joint) = joint {
            max.z = max.z.max(joint + Self::sides(config));
        }
        let below = Self::below(orientation.portion, config);
        Self { min: low - Vec3::new(along_x, along_y, below), max }
    }

    /// Least height of sides: keys of the base, then those of the flange above them [m].
    pub fn sides(config: &Config) -> f64 {
        config.flange.thickness + 4.0 * Sizes::of(config).land()
    }

    /// Width of the level rim of a height field along the sides without bolts [m].
    pub fn rim(config: &Config) -> f64 {
        Joint::band(config) / 2.0
    }

    /// Thickness of the mold below the part [m].
    pub fn below(portion: Portion, config: &Config) -> f64 {
        let needed = match portion {
            Portion::Whole => config.core.length,
            Portion::Above(_) | Portion::Below(_) => config.flange.thickness,
        };
        needed.max(config.wall)
    }

    /// How far below a part without an inlet its sides meet the base: half of what is there,
    /// so that the base does not touch it in a point [m].
    pub fn foot(orientation: &Orientation, pull: Pull, config: &Config) -> f64 {
        match (&orientation.parting, pull, orientation.portion) {
            (
                PartingSurface::Plane(_) | PartingSurface::HeightField(_),
                Pull::Y,
                Portion::Whole,
            ) => Self::below(Portion::Whole, config) / 2.0,
            _ => 0.0,
        }
    }

    /// The box as a solid.
    pub fn solid(&self) -> Solid {
        Solid::cube(&self.min, &self.max)
    }

    /// How far it reaches along a direction [m].
    pub fn reach(&self, along: &Vec3) -> f64 {
        self.min.component_mul(along).sup(&self.max.component_mul(along)).sum()
    }
}
