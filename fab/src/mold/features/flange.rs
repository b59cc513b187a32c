//! What a joint between two pieces carries in the bands along its two ends: keys in
//! three corners, a slot to pry it open in the fourth, bolts between them.

use geometry::frustum::Frustum;
use mesh::Vec3;

use super::key::{RIM, Sizes};
use crate::config::Config;

/// How far holes and slots reach beyond the outside, so that no faces coincide [m].
const BEYOND: f64 = 1e-3;

/// Bolts along one band, at most.
const BOLTS: usize = 2;

/// Radius of a washer over that of its hole: 7 mm for M3 (ISO 7089).
const WASHER: f64 = 2.1;

/// A level rectangle of a joint: x across the bands, y along them, z along the pull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Lowest corner [m].
    pub low: [f64; 2],
    /// Highest corner [m].
    pub high: [f64; 2],
    /// Height of the joint [m].
    pub level: f64,
}

impl Joint {
    /// Width of the band that keys and bolts need at either end [m].
    pub fn band(config: &Config) -> f64 {
        2.0 * Sizes::of(config).land().max(config.flange.bolt + RIM)
    }

    /// Holes for bolts, through both sides.
    pub fn bolts(&self, config: &Config) -> Vec<Frustum> {
        let radius = config.flange.bolt;
        let corner = 2.0 * Sizes::of(config).land();
        let free = self.high[1] - self.low[1] - 2.0 * corner;
        let fit = (free / (2.0 * (radius + RIM))).floor().max(0.0) as usize;
        let count = fit.min(BOLTS);
        let reach = config.flange.thickness + BEYOND;
        let inset = Self::band(config) / 2.0;
        let along = |k: usize| self.low[1] + corner + free * (k as f64 + 0.5) / count as f64;
        let columns = [self.low[0] + inset, self.high[0] - inset];
        let at = columns.into_iter().flat_map(|x| (0..count).map(move |k| [x, along(k)]));
        let hole = |[x, y]: [f64; 2]| {
            let base = Vec3::new(x, y, self.level - reach);
            Frustum::cylinder(base, Vec3::z() * (2.0 * reach), radius)
        };
        at.map(hole).collect()
    }

    /// Side of the square that a bolt beside the corners needs with its washer [m].
    pub fn washer(config: &Config) -> f64 {
        2.0 * WASHER * config.flange.bolt
    }

    /// Holes for bolts beside all four corners, inward along x, from height `bottom` to
    /// `top` [m].
    pub fn corner_bolts(&self, bottom: f64, top: f64, config: &Config) -> Vec<Frustum> {
        let radius = config.flange.bolt;
        let land = Sizes::of(config).land();
        let inset = [2.0 * land + Self::washer(config) / 2.0, land.max(Self::washer(config) / 2.0)];
        let ends = |k: usize| [self.low[k] + inset[k], self.high[k] - inset[k]];
        let at = ends(0).into_iter().flat_map(|x| ends(1).map(|y| [x, y]));
        let axis = Vec3::z() * (top - bottom + 2.0 * BEYOND);
        at.map(|[x, y]| Frustum::cylinder(Vec3::new(x, y, bottom - BEYOND), axis, radius)).collect()
    }

    /// A round slot along x, half in either side, in the corner without a key.
    pub fn pry(&self, config: &Config) -> Frustum {
        let land = Sizes::of(config).land();
        let base = Vec3::new(self.low[0] - BEYOND, self.low[1] + land, self.level);
        Frustum::cylinder(base, Vec3::x() * (BEYOND + land), config.flange.pry)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn nothing_in_a_joint_meets_anything_else() {
        let config = Config::default();
        for length in [0.03, 0.024, 0.06] {
            let joint = Joint { low: [0.0, 0.0], high: [0.05, length], level: 0.01 };
            let sizes = Sizes::of(&config);
            let keys = sizes
                .sites(joint.low, joint.high)
                .map(|[x, y]| sizes.key(Vec3::new(x, y, joint.level)).female.solid());
            let bolts = joint.bolts(&config);
            let corners = joint.corner_bolts(0.0, 0.02, &config);
            let holes: Vec<_> = keys
                .into_iter()
                .chain(
                    bolts.iter().chain(&corners).chain([&joint.pry(&config)]).map(Frustum::solid),
                )
                .collect();
            for (i, a) in holes.iter().enumerate() {
                for b in &holes[i + 1..] {
                    assert!(a.intersection(b).is_empty(), "length {length}");
                }
            }
        }
        let long = Joint { low: [0.0, 0.0], high: [0.05, 0.06], level: 0.0 };
        assert_eq!(long.bolts(&config).len(), 4);
    }
}
