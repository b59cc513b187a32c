//! The shapes a mold is composed of, one per file.

pub mod block;
pub mod core;
pub mod flange;
pub mod key;
pub mod label;
pub mod outside;
pub mod pin;
pub mod support;

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;

use geometry::frustum::{Frustum, SEGMENTS};

/// Largest depth of a channel's mouth, in radii.
const DEEPEST: f64 = 2.0;

/// A channel reaches at least this far into the part [m].
const MOUTH: f64 = 2e-4;

/// The vertical channel above `top`, a point on top of the part, up to height `end` [m].
///
/// It begins below the lowest place of the surface on the rim of its mouth, but not
/// deeper than two radii, so that no film of the shell closes it.
pub fn channel(
    surface: &SurfaceBvh,
    top: &Vec3,
    end: f64,
    base_radius: f64,
    top_radius: f64,
) -> Frustum {
    let deepest = DEEPEST * base_radius;
    let depth_at = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / SEGMENTS as f64;
        let side = Vec3::new(angle.cos(), angle.sin(), 0.0) * base_radius;
        let above = top + side + Vec3::z() * deepest;
        let hits = surface.ray(&above, &-Vec3::z());
        hits.iter().map(|hit| hit.0 - deepest).fold(f64::INFINITY, f64::min)
    };
    let depth = (0..SEGMENTS).map(depth_at).fold(0.0, |deep: f64, d| deep.max(d.min(deepest)));
    let base = top - Vec3::z() * (depth + MOUTH);
    Frustum { base, axis: Vec3::z() * (end - base.z), base_radius, top_radius }
}
