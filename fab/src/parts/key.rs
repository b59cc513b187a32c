//! Conical registration keys: a cone on one piece, a wider hole in the other.

use mesh::Vec3;

use super::Frustum;
use crate::config::Keys;

/// Radius at the tip, as a part of that at the foot.
const TAPER: f64 = 0.5;

/// Material around a key's seat [m].
const RIM: f64 = 1e-3;

/// How far a key is rooted in its piece, in heights.
const ROOT: f64 = 0.5;

/// Half the side of the level square a key needs [m].
#[must_use]
pub fn land(keys: &Keys) -> f64 {
    keys.radius + keys.clearance + RIM
}

/// Places in three corners of a rectangle: pieces turned by 180° do not fit.
#[must_use]
pub fn sites(low: [f64; 2], high: [f64; 2], keys: &Keys) -> [[f64; 2]; 3] {
    let inset = land(keys);
    let [x0, y0] = low.map(|x| x + inset);
    let [x1, y1] = high.map(|x| x - inset);
    [[x1, y0], [x1, y1], [x0, y1]]
}

/// A key that stands on `foot` along z.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The cone, rooted below the foot.
    pub male: Frustum,
    /// The hole for it, from below the foot.
    pub female: Frustum,
    /// The hole above the foot.
    pub seat: Frustum,
}

impl Key {
    /// The key at a point of the joint.
    #[must_use]
    pub fn new(foot: Vec3, keys: &Keys) -> Self {
        let root = -ROOT * keys.height;
        let radius = |z: f64| keys.radius * (1.0 - (1.0 - TAPER) * z / keys.height);
        let cone = |low: f64, clearance: f64| Frustum {
            base: foot + Vec3::z() * low,
            axis: Vec3::z() * (keys.height + clearance - low),
            base_radius: radius(low) + clearance,
            top_radius: radius(keys.height + clearance) + clearance,
        };
        Self {
            male: cone(root, 0.0),
            female: cone(root, keys.clearance),
            seat: cone(0.0, keys.clearance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sites_do_not_fit_when_turned() {
        let keys = Keys::default();
        let sites = sites([-0.05, -0.04], [0.05, 0.04], &keys);
        let turned = sites.map(|[x, y]| [-x, -y]);
        let far =
            |p: [f64; 2]| sites.iter().all(|q| (p[0] - q[0]).hypot(p[1] - q[1]) > keys.radius);
        assert!(turned.iter().any(|&p| far(p)));
    }

    #[test]
    fn the_hole_is_wider_and_deeper_than_the_key_by_the_clearance() {
        let keys = Keys::default();
        let Key { male, female, .. } = Key::new(Vec3::zeros(), &keys);
        assert!((female.base_radius - male.base_radius - keys.clearance).abs() < 1e-15);
        assert!((female.axis.z - male.axis.z - keys.clearance).abs() < 1e-15);
        assert!(male.solid().difference(&female.solid()).volume() < 1e-18);
    }
}
