//! The sprue: a funnel from the top of the mold to the part.

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;

use super::{Frustum, mouth_depth};
use crate::config::Sprue;

/// The funnel above `top`, a point on top of the part, up to height `end` [m].
#[must_use]
pub fn sprue(skin: &SurfaceBvh, top: &Vec3, end: f64, settings: &Sprue) -> Frustum {
    let base = top - Vec3::z() * mouth_depth(skin, top, settings.radius);
    Frustum {
        base,
        axis: Vec3::z() * (end - base.z),
        base_radius: settings.radius,
        top_radius: settings.top_radius,
    }
}
