//! Conical registration keys: a cone on one piece, a wider hole in the other.

use geometry::frustum::Frustum;
use mesh::Vec3;

use crate::config::Config;

/// Radius at the tip, as a part of that at the foot.
const TAPER: f64 = 0.5;

/// Material around a hole in a flange [m].
pub const RIM: f64 = 1e-3;

/// How far a key is rooted in its piece, in heights.
const ROOT: f64 = 0.5;

/// Sizes of all keys of a mold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Radius at the foot [m].
    pub radius: f64,
    /// Height [m].
    pub height: f64,
    /// Gap around it [m].
    pub clearance: f64,
}

impl Sizes {
    /// The sizes of a configuration.
    pub fn of(config: &Config) -> Self {
        let clearance = config.key_clearance();
        Self { radius: config.keys.radius, height: config.keys.height, clearance }
    }

    /// Half the side of the level square a key needs [m].
    pub fn land(&self) -> f64 {
        self.radius + self.clearance + RIM
    }

    /// Places in three corners of a rectangle: pieces turned by 180° do not fit.
    pub fn sites(&self, low: [f64; 2], high: [f64; 2]) -> [[f64; 2]; 3] {
        let inset = self.land();
        let [x0, y0] = low.map(|x| x + inset);
        let [x1, y1] = high.map(|x| x - inset);
        [[x1, y0], [x1, y1], [x0, y1]]
    }

    /// The key that stands on `foot` along z.
    pub fn key(&self, foot: Vec3) -> Key {
        let root = -ROOT * self.height;
        let radius = |z: f64| self.radius * (1.0 - (1.0 - TAPER) * z / self.height);
        let cone = |low: f64, clearance: f64| Frustum {
            base: foot + Vec3::z() * low,
            axis: Vec3::z() * (self.height + clearance - low),
            base_radius: radius(low) + clearance,
            top_radius: radius(self.height + clearance) + clearance,
        };
        let clearance = self.clearance;
        Key { male: cone(root, 0.0), female: cone(root, clearance), seat: cone(0.0, clearance) }
    }
}

/// A cone and the hole for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The cone, rooted below the foot.
    pub male: Frustum,
    /// The hole for it, from below the foot.
    pub female: Frustum,
    /// The hole above the foot.
    pub seat: Frustum,
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: Sizes = Sizes { radius: 3e-3, height: 3e-3, clearance: 2e-4 };

    #[test]
    fn sites_do_not_fit_when_turned() {
        let sites = SIZES.sites([-0.05, -0.04], [0.05, 0.04]);
        let turned = sites.map(|[x, y]| [-x, -y]);
        let far =
            |p: [f64; 2]| sites.iter().all(|q| (p[0] - q[0]).hypot(p[1] - q[1]) > SIZES.radius);
        assert!(turned.iter().any(|&p| far(p)));
    }
}
