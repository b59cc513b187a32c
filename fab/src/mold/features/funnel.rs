//! A funnel that stands in the sprue and holds a head of silicone.
//!
//! A spigot follows the cone of the sprue; above it a cup of height H opens at 45° from
//! radius r to r + H, so that it holds V = π/3 ((r + H)³ − r³).

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::solid::Solid;

use crate::geometry::frustum::{Frustum, SEGMENTS};

/// How far the spigot reaches into the sprue, but not beyond its middle [m].
const DEPTH: f64 = 6e-3;

/// Least depth at which it stands firmly [m].
const LEAST: f64 = 2e-3;

/// Thickness of its wall [m].
const WALL: f64 = 1.2e-3;

/// Width of the ring on which it rests around the sprue [m].
const RING: f64 = 1.2e-3;

/// A funnel that holds `volume` [m³], in `sprue`, with `clearance` around its spigot [m], on
/// a mold with the given outside. None if the sprue is too narrow or too short.
pub fn funnel(sprue: &Frustum, outside: &Solid, volume: f64, clearance: f64) -> Option<Solid> {
    let slope = (sprue.top_radius - sprue.base_radius) / sprue.axis.z;
    let radius = |z: f64| sprue.base_radius + slope * (z - sprue.base.z) - clearance;
    let surface = SurfaceBvh::new(&outside.to_surface());
    let above = sprue.base.z + 2.0 * sprue.axis.z;
    let height = |x: f64, y: f64| {
        let from = Vec3::new(sprue.base.x + x, sprue.base.y + y, above);
        surface.ray(&from, &-Vec3::z()).first().map(|hit| above - hit.0)
    };
    let middle = height(0.0, 0.0)?;
    let reach = radius(middle) + clearance + RING;
    let around = (0..SEGMENTS).filter_map(|k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / SEGMENTS as f64).sin_cos();
        height(reach * cos, reach * sin)
    });
    // Where the outside slopes, the spigot reaches below the lower side of the mouth.
    let (lowest, rest) = around.fold((middle, middle), |(a, b), z| (a.min(z), b.max(z)));
    let bottom = (lowest - DEPTH).max((lowest + sprue.base.z) / 2.0);
    let inner = radius(rest) - WALL;
    if lowest - bottom < LEAST || radius(bottom) <= 1.5 * WALL {
        return None;
    }
    let top = (inner.powi(3) + 3.0 * volume / std::f64::consts::PI).cbrt();
    let cone = |from: f64, to: f64, base_radius: f64, top_radius: f64| {
        let base = Vec3::new(sprue.base.x, sprue.base.y, from);
        Frustum { base, axis: Vec3::z() * (to - from), base_radius, top_radius }.solid()
    };
    let end = rest + (top - inner);
    let (wide, over) = (reach, reach + (end - rest));
    let spigot = cone(bottom, rest + WALL, radius(bottom), radius(rest));
    let bore = cone(bottom - WALL, rest + WALL, radius(bottom) - WALL, inner);
    // Beyond its rim, so that no faces coincide.
    let cup = cone(rest, end + WALL, inner, top + WALL);
    Some(cone(rest, end, wide, over).union(&spigot).difference(&bore).difference(&cup))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_funnel_holds_its_volume_and_stands_in_the_sprue() {
        let outside = Solid::cube(&Vec3::new(-0.03, -0.03, 0.0), &Vec3::new(0.03, 0.03, 0.02));
        let sprue = Frustum {
            base: Vec3::z() * 5e-3,
            axis: Vec3::z() * 16e-3,
            base_radius: 3e-3,
            top_radius: 5.4e-3,
        };
        let mold = outside.difference(&sprue.solid());
        let funnel = funnel(&sprue, &outside, 5e-6, 2e-4).unwrap();
        assert_eq!(funnel.decompose().len(), 1);
        assert_eq!(funnel.genus(), 1);
        assert!(funnel.intersection(&mold).volume() < 1e-15);
        let (low, high) = funnel.bounds();
        assert!((low.z - 14e-3).abs() < 1e-12, "{low}");
        // What is above the mold and within the rim, but not the funnel.
        let around = Solid::cube(&Vec3::new(-0.1, -0.1, 20e-3), &Vec3::new(0.1, 0.1, high.z));
        let parts = around.difference(&funnel).decompose();
        let inside = parts.iter().find(|p| p.bounds().1.x < 0.05).unwrap().volume();
        // A polygon holds less than its circle.
        assert!((0.98..1.0 + 1e-3).contains(&(inside / 5e-6)), "{inside}");
        let narrow = Frustum { base_radius: 8e-4, top_radius: 8e-4, ..sprue };
        assert!(super::funnel(&narrow, &outside, 5e-6, 2e-4).is_none());
    }
}
