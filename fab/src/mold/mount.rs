//! What surrounds the cores of a mold.

use super::piece::Feature;
use crate::config::Config;
use crate::config::method::Method;
use crate::geometry::frame::Frame;

/// What surrounds the cores.
pub struct Mount<'a> {
    /// How the cores leave the body.
    pub method: Method,
    /// Height to which stubs reach [m].
    pub floor: f64,
    /// From the design to the mold.
    pub frame: &'a Frame,
    /// Sprue and vents.
    pub channels: &'a [Feature],
    /// What was asked for.
    pub config: &'a Config,
}
