//! The shapes a mold is composed of, one per file.

pub mod block;
pub mod core;
pub mod key;
pub mod sprue;
pub mod vent;

use mesh::Vec3;
use mesh::solid::Solid;

/// Sides of the prisms that stand for round features.
pub const SEGMENTS: usize = 48;

/// A frustum of a cone: every feature is one or is cut from one.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    /// Centre of the base [m].
    pub base: Vec3,
    /// From the centre of the base to that of the top [m].
    pub axis: Vec3,
    /// Radius of the base [m].
    pub base_radius: f64,
    /// Radius of the top [m].
    pub top_radius: f64,
}

impl Frustum {
    /// The inscribed polyhedron with [`SEGMENTS`] sides.
    #[must_use]
    pub fn solid(&self) -> Solid {
        Solid::cylinder(&self.base, &self.axis, self.base_radius, self.top_radius, SEGMENTS)
    }

    /// With both radii larger by `clearance` and longer by it at both ends [m].
    #[must_use]
    pub fn grown(&self, clearance: f64) -> Self {
        let end = self.axis.normalize() * clearance;
        Self {
            base: self.base - end,
            axis: self.axis + 2.0 * end,
            base_radius: self.base_radius + clearance,
            top_radius: self.top_radius + clearance,
        }
    }
}

/// Largest depth below `top` at which a disc around the vertical through `top`
/// is looked for on the skin, in radii.
const DEEPEST: f64 = 2.0;

/// How far below `top` a vertical channel of this radius must begin so that its
/// whole mouth lies in the part: the lowest place of the skin on its rim,
/// down to [`DEEPEST`] radii.
#[must_use]
pub fn mouth_depth(skin: &mesh::bvh::SurfaceBvh, top: &Vec3, radius: f64) -> f64 {
    let deepest = DEEPEST * radius;
    let depth_at = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / SEGMENTS as f64;
        let side = Vec3::new(angle.cos(), angle.sin(), 0.0) * radius;
        let hits = skin.ray(&(top + side), &-Vec3::z());
        hits.iter().map(|hit| hit.0).fold(f64::INFINITY, f64::min)
    };
    (0..SEGMENTS).map(depth_at).fold(0.0, |deep: f64, d| deep.max(d.min(deepest)))
}
