//! The second support of a core: a pin from its far end up through silicone and mold.
//!
//! It leaves a hole in the silicone, which is plugged afterwards.

use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3};

use crate::geometry::frustum::{Frustum, SEGMENTS};

/// How far a pin is rooted in its core, in radii.
const ROOT: f64 = 2.0;

/// How far the axis is kept from the core's far end, in radii.
const INSET: f64 = 2.0;

/// Distance of the places that are tried, in radii.
const STEP: f64 = 1.0;

/// Least mold between a pin's hole and a sprue or vent [m].
pub const LAND: f64 = 1e-3;

/// Where pins can go.
pub struct PinSpace<'a> {
    /// Outside of the mold.
    pub outside: &'a SurfaceBvh,
    /// Upright channels to keep clear of.
    pub channels: Vec<&'a Frustum>,
    /// Gap around the pin [m].
    pub clearance: f64,
    /// The plane y = level on which it has to stand, if there is one [m].
    pub level: Option<f64>,
    /// Whether the silicone around a pin is thick enough.
    pub leaves_walls: &'a dyn Fn(&Frustum) -> bool,
}

/// No place for a pin.
#[derive(Debug, thiserror::Error, PartialEq)]
#[error(
    "core.support = \"pin\": no pin of {radius_mm:.2} mm radius finds room between the core's far end at \
     ({x:.1}, {y:.1}) mm and its middle: of {tried} places the core is missing below {missing}, and sprue or vents \
     are nearer than {apart_mm:.1} mm to {blocked}, and silicone thinner than casting.least_wall would be left beside \
     {thin}; move sprue.at away, make core.pin thinner, or hold the core by \
     its stub",
    x = end.x * 1e3, y = end.y * 1e3, radius_mm = radius * 1e3, apart_mm = LAND * 1e3
)]
pub struct PinError {
    /// Far end of the core in the mold's frame [m].
    end: Vec3,
    radius: f64,
    tried: usize,
    missing: usize,
    blocked: usize,
    thin: usize,
}

/// The pin of `radius` [m] nearest to the point of the core farthest from `inlet`, and at
/// most as far from there as the core's middle, from within the core up to just below the
/// outside.
///
/// # Errors
/// [`PinError`] if there is no space.
pub fn pin(
    core: &SurfaceMesh,
    inlet: &Vec3,
    radius: f64,
    space: &PinSpace,
) -> Result<Frustum, PinError> {
    let far = |p: &&Vec3| (*p - inlet).norm_squared();
    let end = *core.vertices.iter().max_by(|a, b| far(a).total_cmp(&far(b))).expect("a core");
    let middle = core.vertices.iter().sum::<Vec3>() / core.vertices.len() as f64;
    let way = Vec3::new(middle.x - end.x, middle.y - end.y, 0.0);
    // A core straight above its inlet has its middle there.
    let inward = way.try_normalize(1e-12).unwrap_or_else(Vec3::x);
    let steps = ((way.norm() / radius - INSET) / STEP).max(0.0) as usize;
    let (mut missing, mut blocked, mut thin) = (0, 0, 0);
    let bvh = SurfaceBvh::new(core);
    for k in 0..=steps {
        let reach = ((INSET + STEP * k as f64) * radius).min(way.norm());
        let mut at = end + inward * reach;
        at.y = space.level.unwrap_or(at.y);
        if !space.is_clear(&at, radius) {
            blocked += 1;
            continue;
        }
        match standing(&bvh, &at, radius, space) {
            Some(found) if (space.leaves_walls)(&found) => return Ok(found),
            Some(_) => thin += 1,
            None => missing += 1,
        }
    }
    Err(PinError { end, radius, tried: steps + 1, missing, blocked, thin })
}

/// The pin on the upright line through `at`, if the core lies there.
fn standing(core: &SurfaceBvh, at: &Vec3, radius: f64, space: &PinSpace) -> Option<Frustum> {
    let top = space.top(at, radius)?;
    let above = Vec3::new(at.x, at.y, top);
    let base = above - Vec3::z() * (core.ray(&above, &-Vec3::z()).first()?.0 + ROOT * radius);
    Some(Frustum { base, axis: above - base, base_radius: radius, top_radius: radius })
}

impl PinSpace<'_> {
    /// Whether mold is left between the hole of a pin and all channels.
    fn is_clear(&self, at: &Vec3, radius: f64) -> bool {
        self.channels.iter().all(|channel| {
            let widest = channel.base_radius.max(channel.top_radius);
            let apart = (at - channel.base).xy().norm();
            apart >= radius + self.clearance + widest + LAND
        })
    }

    /// Height below which a pin ends inside the outside, which may slope [m].
    fn top(&self, at: &Vec3, radius: f64) -> Option<f64> {
        const ABOVE: f64 = 1.0;
        let height = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / SEGMENTS as f64;
            let p = at + Vec3::new(angle.cos(), angle.sin(), 0.0) * radius + Vec3::z() * ABOVE;
            self.outside.ray(&p, &-Vec3::z()).first().map(|hit| p.z - hit.0)
        };
        let lowest = (0..SEGMENTS).map(height).try_fold(f64::INFINITY, |m, h| Some(h?.min(m)));
        lowest.map(|lowest| lowest - self.clearance)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::solid::Solid;

    /// A rod of 50 mm along x, held at x = 0, in a mold whose top slopes from z = 20 mm at
    /// x = 40 mm down by 1:1, with an upright channel. Beyond x = `most` walls are too thin.
    fn placed(level: Option<f64>, channel: f64, most: f64) -> Result<Frustum, PinError> {
        let rod = Solid::cube(&Vec3::new(0.0, -4e-3, 0.0), &Vec3::new(50e-3, 4e-3, 8e-3));
        let mold = Solid::cube(&Vec3::repeat(-10e-3), &Vec3::new(60e-3, 10e-3, 20e-3));
        let slope = Vec3::new(-1.0, 0.0, -1.0).normalize();
        let mold = mold.trim_by_plane(&slope, -60e-3 / 2.0_f64.sqrt()).to_surface();
        let channel = Frustum {
            base: Vec3::new(channel, 0.0, 8e-3),
            axis: Vec3::z() * 12e-3,
            base_radius: 1e-3,
            top_radius: 2e-3,
        };
        let space = PinSpace {
            outside: &SurfaceBvh::new(&mold),
            channels: vec![&channel],
            clearance: 2e-4,
            level,
            leaves_walls: &|pin| pin.base.x < most,
        };
        pin(&rod.to_surface(), &Vec3::zeros(), 1e-3, &space)
    }

    #[test]
    fn a_pin_stands_near_the_far_end_is_rooted_and_ends_inside_the_mold() {
        let found = placed(Some(0.0), 0.0, 1.0).unwrap();
        assert!((45e-3..50e-3).contains(&found.base.x), "{found:?}");
        assert!((found.base.z - 6e-3).abs() < 1e-12, "{found:?}");
        assert_eq!(found.base.y, 0.0);
        // The slope at the far side of the pin.
        let top = 60e-3 - (found.base.x + 1e-3) - 2e-4;
        assert!((found.base.z + found.axis.z - top).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_pin_makes_way_for_a_channel_or_is_refused() {
        let alone = placed(Some(0.0), 0.0, 1.0).unwrap();
        let beside = placed(Some(0.0), alone.base.x, 1.0).unwrap();
        let apart = alone.base.x - beside.base.x;
        assert!((4.2e-3..5.3e-3).contains(&apart), "{apart}");
        // The next place, about a radius further in.
        let thicker = placed(Some(0.0), 0.0, alone.base.x).unwrap();
        let apart = alone.base.x - thicker.base.x;
        assert!((0.5e-3..=1e-3).contains(&apart), "{apart}");
        let error = placed(Some(9e-3), 0.0, 1.0).unwrap_err();
        assert_eq!(error.tried, error.missing);
        assert!(error.to_string().contains("finds room"), "{error}");
    }
}
