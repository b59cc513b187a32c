//! How a body stands in a mold, and how the mold comes apart.

use mesh::Vec3;

use crate::config::HeightFieldConfig;

/// Everything that decides about the pieces of a mold, in the design's coordinates.
#[derive(Clone, Debug)]
pub struct Orientation {
    /// Unit vector that points up while casting [1].
    pub up: Vec3,
    /// Unit vector along which the shells separate, along or across `up` [1].
    pub pull: Vec3,
    /// Where they separate.
    pub parting: PartingSurface,
    /// What is cast.
    pub portion: Portion,
    /// Position along `up` at which shells that are pulled across it stand on their base.
    /// Unset: where the body stands, or is cut [m].
    pub joint: Option<f64>,
}

/// Where shells separate.
#[derive(Clone, Debug)]
pub enum PartingSurface {
    /// On a plane across the pull, at this position along it [m].
    Plane(f64),
    /// On a height over the plane across the pull.
    HeightField(HeightFieldConfig),
    /// Where the body stands: a cup over a plate. Only along `up`.
    Seat,
    /// Nowhere: a tray, open above.
    Open,
}

/// The part of a body that is cast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Portion {
    /// All of it; its cores stand on stubs in the lowest piece.
    Whole,
    /// What is above a position along `up` [m]; the lowest piece carries the core.
    Above(f64),
    /// What is below a position along `up` [m].
    Below(f64),
}

impl Portion {
    /// Position of the cut along `up` [m].
    pub fn cut(self) -> Option<f64> {
        match self {
            Self::Whole => None,
            Self::Above(offset) | Self::Below(offset) => Some(offset),
        }
    }
}
