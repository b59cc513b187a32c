//! Implicit primitives: a function that is negative inside and zero on the
//! surface, and a box that contains the inside.
//!
//! Spheres, boxes, capsules with equal radii and cylinders are exact signed
//! distances. An ellipsoid uses k₀(k₀ − 1)/k₁ with k₀ = |q/r|, k₁ = |q/r²|, which
//! is a distance to first order near its surface; a capsule with two radii
//! interpolates the radius along its axis. Lengths are in the unit of the model
//! file.

use mesh::Vec3;
use nalgebra::Matrix3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A box as its (min, max) corners [unit].
pub type Bounds = (Vec3, Vec3);

/// Geometry of one primitive.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Centre [unit].
        center: [f64; 3],
        /// Radius [unit].
        radius: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Centre [unit].
        center: [f64; 3],
        /// Half-axes [unit].
        radii: [f64; 3],
        /// Pitch, yaw, roll [deg].
        #[serde(default)]
        rotation: Rotation,
    },
    /// A segment thickened by a radius that varies linearly along it.
    Capsule {
        /// Start of the axis [unit].
        from: [f64; 3],
        /// End of the axis [unit].
        to: [f64; 3],
        /// Radius at the start and at the end [unit].
        radii: [f64; 2],
    },
    /// A circular cylinder with flat ends.
    Cylinder {
        /// Centre of the first end [unit].
        from: [f64; 3],
        /// Centre of the second end [unit].
        to: [f64; 3],
        /// Radius [unit].
        radius: f64,
    },
    /// A box whose edges and corners may be rounded.
    Box {
        /// Centre [unit].
        center: [f64; 3],
        /// Full edge lengths, rounding included [unit].
        size: [f64; 3],
        /// Radius of the rounding [unit].
        #[serde(default)]
        rounding: f64,
        /// Pitch, yaw, roll [deg].
        #[serde(default)]
        rotation: Rotation,
    },
    /// Not a body: a groove in all primitives before it, along the plane
    /// n·p = offset. It adds depth · exp(−(s/width)²) · S to the distance, where
    /// s = n·p − offset and S rises smoothly from 0 to 1 for x in `fade`.
    Crease {
        /// n, not normalised.
        normal: [f64; 3],
        /// n·p on the groove [unit].
        offset: f64,
        /// Half-width at which the depth has fallen to 1/e [unit].
        width: f64,
        /// Depth [unit].
        depth: f64,
        /// x where the groove begins and where it has its full depth [unit].
        fade: [f64; 2],
    },
}

/// R = R_z(yaw) R_y(pitch) R_x(roll), written as [pitch, yaw, roll] in degrees;
/// positive pitch turns +x towards −z.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(from = "[f64; 3]")]
#[schemars(with = "[f64; 3]")]
pub struct Rotation(Matrix3<f64>);

impl From<[f64; 3]> for Rotation {
    fn from(degrees: [f64; 3]) -> Self {
        let [pitch, yaw, roll] = degrees.map(f64::to_radians);
        Self(nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw).into_inner())
    }
}

impl Default for Rotation {
    fn default() -> Self {
        Self(Matrix3::identity())
    }
}

impl Rotation {
    /// Rᵀ v.
    pub(super) fn turned_back(&self, v: &Vec3) -> Vec3 {
        self.0.tr_mul(v)
    }

    /// F R F with the reflection F in y.
    fn mirrored(self) -> Self {
        let flip = Matrix3::from_diagonal(&Vec3::new(1.0, -1.0, 1.0));
        Self(flip * self.0 * flip)
    }
}

impl Shape {
    /// Signed distance, negative inside; for a crease the height to add [unit].
    pub fn distance(&self, p: &Vec3) -> f64 {
        match self {
            Self::Sphere { center, radius } => (p - Vec3::from(*center)).norm() - radius,
            Self::Ellipsoid { center, radii, rotation } => {
                ellipsoid(&rotation.turned_back(&(p - Vec3::from(*center))), &Vec3::from(*radii))
            }
            Self::Capsule { from, to, radii } => {
                let (t, distance) = to_segment(p, &Vec3::from(*from), &Vec3::from(*to));
                distance - (radii[0] + (radii[1] - radii[0]) * t)
            }
            Self::Cylinder { from, to, radius } => {
                cylinder(p, &Vec3::from(*from), &Vec3::from(*to), *radius)
            }
            Self::Box { center, size, rounding, rotation } => {
                let q = rotation.turned_back(&(p - Vec3::from(*center)));
                let d = q.abs() - Vec3::from(*size) / 2.0 + Vec3::repeat(*rounding);
                d.map(|x| x.max(0.0)).norm() + d.max().min(0.0) - rounding
            }
            Self::Crease { normal, offset, width, depth, fade } => {
                let s = Vec3::from(*normal).dot(p) - offset;
                let rise = smoothstep((p.x - fade[0]) / (fade[1] - fade[0]));
                depth * (-(s / width).powi(2)).exp() * rise
            }
        }
    }

    /// A box around the inside; none for a crease.
    pub fn bounds(&self) -> Option<Bounds> {
        let around = |c: &[f64; 3], half: Vec3| {
            let c = Vec3::from(*c);
            (c - half, c + half)
        };
        Some(match self {
            Self::Sphere { center, radius } => around(center, Vec3::repeat(*radius)),
            Self::Ellipsoid { center, radii, rotation } => {
                // Support of the ellipsoid in direction eᵢ: |diag(r) Rᵀ eᵢ|.
                let axes = rotation.0 * Matrix3::from_diagonal(&Vec3::from(*radii));
                around(center, Vec3::from_fn(|i, _| axes.row(i).norm()))
            }
            Self::Capsule { from, to, radii } => segment(from, to, radii[0].max(radii[1])),
            Self::Cylinder { from, to, radius } => segment(from, to, *radius),
            Self::Box { center, size, rotation, .. } => {
                around(center, rotation.0.abs() * Vec3::from(*size) / 2.0)
            }
            Self::Crease { .. } => return None,
        })
    }

    /// The width of the inside where it is thinnest; none for a crease [unit].
    pub fn thickness(&self) -> Option<f64> {
        let least = |lengths: &[f64]| lengths.iter().copied().fold(f64::INFINITY, f64::min);
        Some(match self {
            Self::Sphere { radius, .. } => 2.0 * radius,
            Self::Ellipsoid { radii, .. } => 2.0 * least(radii),
            Self::Capsule { radii, .. } => 2.0 * least(radii),
            Self::Cylinder { from, to, radius } => {
                (2.0 * radius).min((Vec3::from(*to) - Vec3::from(*from)).norm())
            }
            Self::Box { size, .. } => least(size),
            Self::Crease { .. } => return None,
        })
    }

    /// The mirror image in the plane y = 0.
    pub fn mirrored(&self) -> Self {
        let flip = |v: &mut [f64; 3]| v[1] = -v[1];
        let mut image = self.clone();
        match &mut image {
            Self::Sphere { center, .. } => flip(center),
            Self::Ellipsoid { center, rotation, .. } | Self::Box { center, rotation, .. } => {
                flip(center);
                *rotation = rotation.mirrored();
            }
            Self::Capsule { from, to, .. } | Self::Cylinder { from, to, .. } => {
                flip(from);
                flip(to);
            }
            Self::Crease { normal, .. } => flip(normal),
        }
        image
    }

    /// What is wrong with the numbers, if anything.
    pub fn check(&self) -> Result<(), String> {
        let positive = |what: &str, values: &[f64]| {
            let ok = values.iter().all(|&v| v > 0.0);
            ok.then_some(()).ok_or_else(|| format!("{what} must be positive, found {values:?}"))
        };
        let apart = |from: &[f64; 3], to: &[f64; 3]| {
            let ok = from != to;
            ok.then_some(()).ok_or_else(|| format!("`from` and `to` are the same point {from:?}"))
        };
        match self {
            Self::Sphere { radius, .. } => positive("radius", &[*radius]),
            Self::Ellipsoid { radii, .. } => positive("radii", radii),
            Self::Capsule { from, to, radii } => positive("radii", radii).and(apart(from, to)),
            Self::Cylinder { from, to, radius } => {
                positive("radius", &[*radius]).and(apart(from, to))
            }
            Self::Box { size, rounding, .. } => {
                let limit = size.iter().fold(f64::INFINITY, |m, &s| m.min(s)) / 2.0;
                if !(0.0..=limit).contains(rounding) {
                    return Err(format!(
                        "rounding {rounding} must lie between 0 and half the shortest edge, {limit}"
                    ));
                }
                positive("size", size)
            }
            Self::Crease { normal, width, fade, .. } => {
                if fade[0] >= fade[1] {
                    return Err(format!("fade must rise, found {fade:?}"));
                }
                positive("width", &[*width])
                    .and(positive("the length of the normal", &[Vec3::from(*normal).norm()]))
            }
        }
    }
}

/// S(t) = t²(3 − 2t) clamped to [0, 1].
pub fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn ellipsoid(q: &Vec3, r: &Vec3) -> f64 {
    let k0 = q.component_div(r).norm();
    let k1 = q.component_div(&r.component_mul(r)).norm();
    // At the centre the quotient is 0/0; minus the smallest half-axis is its limit
    // along that axis.
    if k1 == 0.0 { -r.min() } else { k0 * (k0 - 1.0) / k1 }
}

/// Clamped parameter in [0, 1] of the closest point of a segment, and its distance.
fn to_segment(p: &Vec3, a: &Vec3, b: &Vec3) -> (f64, f64) {
    let axis = b - a;
    let t = ((p - a).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
    (t, (p - a - axis * t).norm())
}

fn cylinder(p: &Vec3, a: &Vec3, b: &Vec3, radius: f64) -> f64 {
    let axis = (b - a).normalize();
    let along = (p - (a + b) / 2.0).dot(&axis);
    let radial = (p - a - axis * (p - a).dot(&axis)).norm() - radius;
    let axial = along.abs() - (b - a).norm() / 2.0;
    radial.max(0.0).hypot(axial.max(0.0)) + radial.max(axial).min(0.0)
}

fn segment(a: &[f64; 3], b: &[f64; 3], radius: f64) -> Bounds {
    let (a, b) = (Vec3::from(*a), Vec3::from(*b));
    (a.inf(&b).add_scalar(-radius), a.sup(&b).add_scalar(radius))
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// One primitive of each kind that is a body.
    pub(crate) fn shapes() -> Vec<Shape> {
        let rotation = Rotation::from([30.0, -50.0, 70.0]);
        vec![
            Shape::Sphere { center: [1.0, 2.0, -1.0], radius: 1.5 },
            Shape::Ellipsoid { center: [0.5, 1.0, 0.0], radii: [3.0, 2.0, 1.0], rotation },
            Shape::Capsule { from: [0.0; 3], to: [3.0, 1.0, 2.0], radii: [1.0, 0.5] },
            Shape::Cylinder { from: [0.0; 3], to: [1.0, 2.0, 2.0], radius: 0.7 },
            Shape::Box { center: [1.0; 3], size: [4.0, 3.0, 2.0], rounding: 0.4, rotation },
        ]
    }

    fn grid() -> impl Iterator<Item = Vec3> {
        let steps = || (-20..=20).map(|i| f64::from(i) * 0.31);
        steps()
            .flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| Vec3::new(x, y, z))))
    }

    #[test]
    fn the_inside_lies_in_the_bounds() {
        for shape in shapes() {
            let (min, max) = shape.bounds().unwrap();
            let mut inside = 0;
            for p in grid().filter(|p| shape.distance(p) <= 0.0) {
                inside += 1;
                assert!((0..3).all(|k| min[k] <= p[k] && p[k] <= max[k]), "{shape:?} {p}");
            }
            assert!(inside > 50, "{shape:?}: only {inside} points inside");
        }
    }

    #[test]
    fn exact_distances_have_unit_slope() {
        let h = 1e-5;
        for shape in [&shapes()[0], &shapes()[3], &shapes()[4]] {
            for p in grid().filter(|p| shape.distance(p) > 0.1).step_by(97) {
                let slope = Vec3::from_fn(|k, _| {
                    let e = Vec3::from_fn(|i, _| if i == k { h } else { 0.0 });
                    (shape.distance(&(p + e)) - shape.distance(&(p - e))) / (2.0 * h)
                });
                // Central differences err by h² times a third derivative below 1e3.
                assert!((slope.norm() - 1.0).abs() < 1e-6, "{shape:?} {p} {}", slope.norm());
            }
        }
    }

    #[test]
    fn mirroring_reflects_in_y() {
        for shape in shapes() {
            let image = shape.mirrored();
            for p in grid().step_by(61) {
                let q = Vec3::new(p.x, -p.y, p.z);
                assert!((shape.distance(&p) - image.distance(&q)).abs() < 1e-12, "{shape:?}");
            }
        }
    }
}
