//! Vents: thin channels that let the air out where it would be caught.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;

use super::{Frustum, mouth_depth};
use crate::config::Vents;

/// The channel above `top`, a local maximum of the part, up to height `end` [m].
#[must_use]
pub fn vent(skin: &SurfaceBvh, top: &Vec3, end: f64, settings: &Vents) -> Frustum {
    let base = top - Vec3::z() * mouth_depth(skin, top, settings.radius);
    Frustum {
        base,
        axis: Vec3::z() * (end - base.z),
        base_radius: settings.radius,
        top_radius: settings.radius,
    }
}
