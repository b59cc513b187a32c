//! The second support of a core: a pin from its far end up through silicone and mold.
//!
//! It leaves a hole in the silicone, which is plugged afterwards.

use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3};

use super::Frustum;

/// How far a pin is rooted in its core, in radii.
const ROOT: f64 = 2.0;

/// How far the axis is kept from the core's far end, in radii.
const INSET: f64 = 2.0;

/// A pin of `radius` from the core near its point farthest from `inlet` up to height
/// `top` [m]; on the plane y = `level` if one is given. None if the core is not there.
#[must_use]
pub fn pin(
    core: &SurfaceMesh,
    inlet: &Vec3,
    radius: f64,
    top: f64,
    level: Option<f64>,
) -> Option<Frustum> {
    let far = |p: &&Vec3| (*p - inlet).norm_squared();
    let end = core.vertices.iter().max_by(|a, b| far(a).total_cmp(&far(b)))?;
    let middle = core.vertices.iter().sum::<Vec3>() / core.vertices.len() as f64;
    let inward = Vec3::new(middle.x - end.x, middle.y - end.y, 0.0);
    let step = (INSET * radius).min(inward.norm());
    let mut at = end + inward.normalize() * step;
    at.y = level.unwrap_or(at.y);
    let above = Vec3::new(at.x, at.y, top);
    let hits = SurfaceBvh::new(core).ray(&above, &-Vec3::z());
    let base = above - Vec3::z() * (hits.first()?.0 + ROOT * radius);
    Some(Frustum { base, axis: above - base, base_radius: radius, top_radius: radius })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::solid::Solid;

    #[test]
    fn a_pin_stands_near_the_far_end_and_is_rooted() {
        // A rod of 50 mm along x, held at x = 0.
        let rod = Solid::cube(&Vec3::new(0.0, -4e-3, 0.0), &Vec3::new(50e-3, 4e-3, 8e-3));
        let surface = rod.to_surface();
        let found = pin(&surface, &Vec3::zeros(), 1e-3, 20e-3, Some(0.0)).unwrap();
        assert!((45e-3..50e-3).contains(&found.base.x), "{found:?}");
        assert!((found.base.z - 6e-3).abs() < 1e-12, "{found:?}");
        assert!((found.base.z + found.axis.z - 20e-3).abs() < 1e-12, "{found:?}");
        assert_eq!(found.base.y, 0.0);
        assert_eq!(pin(&surface, &Vec3::zeros(), 1e-3, 20e-3, Some(9e-3)), None);
    }
}
