//! Fields of directions, as several tables write them: one vector for all, or an axis with an angle.

use anyhow::Result;
use mechanics::energy::Direction;
use program::table::Range;
use program::{KeyPath, misfit};

use super::line::{AroundConfig, unit};

/// Angles to an axis [°].
pub(super) const ANGLE: Range = Range::between(-360.0, 360.0).unit("°");

/// What gives an angle its axis, for messages.
pub(super) const AXIS: &str = "add around = { point = [0, 0, 0], axis = [0, 0, 1] }";

/// Keys of a direction field.
pub(super) struct Leads<'a> {
    /// The same direction everywhere.
    pub direction: Option<[f64; 3]>,
    /// An axis.
    pub around: Option<&'a AroundConfig>,
    /// Angle to it [°].
    pub angle: Option<f64>,
    /// Whether it leads away from it.
    pub radial: bool,
}

impl Leads<'_> {
    /// Whether any of them is given.
    pub fn any(&self) -> bool {
        let Self { direction, around, angle, radial } = self;
        direction.is_some() || around.is_some() || angle.is_some() || *radial
    }

    /// The field.
    pub fn field(&self, title: &KeyPath) -> Result<Direction> {
        let key = |key: &str| title.clone().key(key);
        let refused = match (self.direction, self.around, self.angle, self.radial) {
            (Some(direction), None, None, false) => {
                return Ok(Direction::Constant(unit(direction)));
            }
            (None, Some(around), Some(angle), false) => {
                return Ok(Direction::Helical(around.line(), angle.to_radians()));
            }
            (None, Some(around), None, true) => return Ok(Direction::Radial(around.line())),
            (Some(_), Some(_), ..) => {
                misfit!(key("direction"), " beside around: expected one of both")
            }
            (_, None, Some(_), _) => misfit!(key("angle"), " without an axis: {AXIS}"),
            (_, None, None, true) => misfit!(key("radial"), " without an axis: {AXIS}"),
            (None, Some(_), Some(_), true) => {
                misfit!(key("radial"), " beside angle: expected one of both")
            }
            (None, Some(_), None, false) => misfit!(
                key("around"),
                " without angle: expected angle = 0 (along the axis) to 90 (around it), or radial = true"
            ),
            (None, None, None, false) => misfit!(
                title.clone(),
                " has no direction: expected direction = [x, y, z], or around = {{ point = …, axis = … }} with angle"
            ),
        };
        Err(refused.into())
    }
}
