//! Bounds of implicit functions over balls, so that regions without a surface are left out unseen.
//!
//! Most primitives are distances: over a ball of radius r they change by r at most. All operations of a
//! [`super::Field`] rise or fall with each of their arguments, so that bounds follow from bounds.

use mesh::Vec3;

use super::shape::{Shape, smoothstep};

/// The least and the largest value, or bounds of them.
pub type Range = (f64, f64);

impl Shape {
    /// Bounds of [`Shape::distance`] over the ball around `c` with the radius `r` [unit].
    pub fn range(&self, c: &Vec3, r: f64) -> Range {
        let around = |slope: f64| {
            let d = self.distance(c);
            (d - slope * r, d + slope * r)
        };
        match self {
            Self::Sphere { .. } | Self::Cylinder { .. } | Self::Box { .. } => around(1.0),
            Self::Capsule { from, to, radii } => {
                let length = (Vec3::from(*to) - Vec3::from(*from)).norm();
                around(1.0 + (radii[1] - radii[0]).abs() / length)
            }
            Self::Ellipsoid { center, radii, rotation } => {
                ellipsoid(&rotation.turned_back(&(c - Vec3::from(*center))), &Vec3::from(*radii), r)
            }
            Self::Crease { normal, offset, width, depth, fade } => {
                let normal = Vec3::from(*normal);
                let (s, play) = ((normal.dot(c) - offset).abs(), normal.norm() * r);
                let bell = |s: f64| (-(s / width).powi(2)).exp();
                let rise = |x: f64| smoothstep((x - fade[0]) / (fade[1] - fade[0]));
                let least = depth * bell(s + play) * rise(c.x - r);
                let most = depth * bell((s - play).max(0.0)) * rise(c.x + r);
                (least.min(most), least.max(most))
            }
        }
    }
}

/// Bounds of k₀(k₀ − 1)/k₁ over a ball. Both k are convex: below they are bounded by their tangents,
/// above by those and half their largest second derivative.
fn ellipsoid(q: &Vec3, radii: &Vec3, r: f64) -> Range {
    let norm = |power: i32| {
        let scale = radii.map(|a| a.powi(-power));
        let k = q.component_mul(&scale).norm();
        let slope =
            if k > 0.0 { q.component_mul(&scale).component_mul(&scale).norm() / k } else { 0.0 };
        let steepest = scale.max();
        let low = (k - slope * r).max(0.0);
        let bend = if low > 0.0 { steepest * steepest / low } else { f64::INFINITY };
        (low, k + (steepest * r).min(slope * r + bend * r * r / 2.0))
    };
    let (k0, k1) = (norm(1), norm(2));
    let least = radii.min().max(k0.0 / k1.1);
    let most = if k1.0 > 0.0 { radii.max().min(k0.1 / k1.0) } else { radii.max() };
    let low = (k0.0 - 1.0) * if k0.0 > 1.0 { least } else { most };
    let high = (k0.1 - 1.0) * if k0.1 > 1.0 { most } else { least };
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::shapes;
    use super::*;

    /// Points in the unit ball, evenly enough.
    fn ball() -> impl Iterator<Item = Vec3> {
        let steps = || (-5..=5).map(|i| f64::from(i) / 5.0);
        let all = steps()
            .flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| Vec3::new(x, y, z))));
        all.filter(|p| p.norm() <= 1.0)
    }

    #[test]
    fn values_in_a_ball_lie_in_their_range() {
        let crease = Shape::Crease {
            normal: [0.2, 0.0, 1.0],
            offset: 0.3,
            width: 0.4,
            depth: -0.5,
            fade: [-1.0, 1.5],
        };
        for shape in shapes().into_iter().chain([crease]) {
            for center in ball().step_by(7).map(|p| p * 5.0) {
                for r in [0.05, 0.4, 2.0] {
                    let (low, high) = shape.range(&center, r);
                    let slack = 1e-12 * (1.0 + high.abs());
                    for d in ball().map(|p| shape.distance(&(center + p * r))) {
                        assert!(
                            low - slack <= d && d <= high + slack,
                            "{shape:?}: {low} {d} {high}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_small_ball_has_a_narrow_range() {
        for shape in shapes() {
            for center in ball().step_by(11).map(|p| p * 5.0).filter(|c| shape.distance(c) > 0.0) {
                let (low, high) = shape.range(&center, 1e-4);
                // A distance changes by 2e-4; an ellipsoid of 3:1 is no distance far from it.
                assert!(high - low < 2e-3, "{shape:?} {center}: {}", high - low);
            }
        }
    }
}
