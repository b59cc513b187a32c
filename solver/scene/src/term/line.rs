//! Lines in space and directions, as tables give them.

use mechanics::energy::Axis;
use mesh::Vec3;
use program::table::Range;
use program::{KeyPath, Misfit, table};

program::table! {
    /// A line in space.
    #[derive(Clone, Debug, PartialEq)]
    pub struct AroundConfig {
        /// A point on it [m].
        point: [f64; 3], Range::FINITE.unit("m");
        /// A vector along it, of any length.
        axis: [f64; 3], direction;
    }
}

fn direction(at: &KeyPath, vector: &[f64; 3]) -> Result<(), Misfit> {
    table::direction(at, &Some(*vector))
}

impl AroundConfig {
    /// The line.
    pub fn line(&self) -> Axis {
        Axis { point: self.point.into(), along: unit(self.axis) }
    }
}

/// The unit vector along a direction.
pub(super) fn unit(direction: [f64; 3]) -> Vec3 {
    Vec3::from(direction) / Vec3::from(direction).norm()
}
