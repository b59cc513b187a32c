//! The mold's own coordinates, and turns of pieces for printing.
//!
//! In the mold's frame z points up while casting and the shells separate along
//! z or along y. The part stands on z = 0, centred on the z axis.

use mesh::{SurfaceMesh, Vec3};
use nalgebra::Matrix3;

/// Directions that agree to this cosine count as parallel.
const PARALLEL: f64 = 1.0 - 1e-9;

/// A map from the design to the mold: x ↦ s R (x − o).
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Scale s: above 1 for a silicone that shrinks [1].
    pub scale: f64,
    /// Rotation R; its rows are the mold's axes in the design [1].
    pub rotation: Matrix3<f64>,
    /// Design point o that becomes the mold's origin [m].
    pub origin: Vec3,
}

/// The direction in which the shells separate, in the mold's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pull {
    /// Upper and lower shell; the core sits in the lower one.
    Z,
    /// Left and right shell on a base; the core sits in the base.
    Y,
}

impl Frame {
    /// A frame at the design's origin with z = `up`, and y = `pull` unless the two are parallel.
    pub fn new(up: Vec3, pull: Vec3) -> Result<(Self, Pull), f64> {
        let z = up.normalize();
        let pull = pull.normalize();
        let cosine = z.dot(&pull);
        let (y, direction) = if cosine.abs() >= PARALLEL {
            (z.cross(&across(z)), Pull::Z)
        } else if cosine.abs() <= 1.0 - PARALLEL {
            (pull, Pull::Y)
        } else {
            return Err(cosine);
        };
        let x = y.cross(&z).normalize();
        let y = z.cross(&x);
        let rotation = Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]);
        Ok((Self { scale: 1.0, rotation, origin: Vec3::zeros() }, direction))
    }

    /// The image of a design point [m].
    pub fn point(&self, p: &Vec3) -> Vec3 {
        self.rotation * (p - self.origin) * self.scale
    }

    /// The image of a direction.
    pub fn direction(&self, d: &Vec3) -> Vec3 {
        self.rotation * d
    }
}

/// A surface with its vertices moved.
pub fn moved(surface: &SurfaceMesh, place: impl Fn(&Vec3) -> Vec3) -> SurfaceMesh {
    let vertices = surface.vertices.iter().map(place).collect();
    SurfaceMesh { vertices, triangles: surface.triangles.clone() }
}

/// A unit vector across `axis`, along x or y of the design as far as possible.
fn across(axis: Vec3) -> Vec3 {
    let seed = if axis.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
    (seed - axis * axis.dot(&seed)).normalize()
}

/// A rotation about the x axis by a multiple of 90°: exact, because it only permutes and negates coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn(pub Matrix3<f64>);

impl Turn {
    /// None.
    pub const NONE: Self = Self(Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0));

    /// The turn that brings `direction`, one of ±y and ±z, to −z.
    ///
    /// # Panics
    /// If `direction` is none of these.
    pub fn lowering(direction: Vec3) -> Self {
        let rows = match (direction.y, direction.z) {
            (0.0, -1.0) => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            (0.0, 1.0) => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            (1.0, 0.0) => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
            (-1.0, 0.0) => [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
            _ => panic!("a piece is pulled along ±y or ±z, not along {direction:?}"),
        };
        Self(Matrix3::from_fn(|i, j| rows[i][j]))
    }

    /// The turn back.
    pub fn inverse(self) -> Self {
        Self(self.0.transpose())
    }
}

impl Pull {
    /// The unit vector.
    pub fn vector(self) -> Vec3 {
        match self {
            Self::Z => Vec3::z(),
            Self::Y => Vec3::y(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn frames_are_right_handed_and_put_up_on_z() {
        let cases = [
            (Vec3::z(), Vec3::z(), Pull::Z),
            (Vec3::x(), -Vec3::x(), Pull::Z),
            (Vec3::x(), Vec3::y(), Pull::Y),
            (Vec3::new(1.0, 1.0, 0.0), Vec3::z(), Pull::Y),
        ];
        for (up, pull, expected) in cases {
            let (frame, direction) = Frame::new(up, pull).unwrap();
            assert_eq!(direction, expected);
            assert!((frame.rotation.determinant() - 1.0).abs() < 1e-15);
            assert!((frame.direction(&up.normalize()) - Vec3::z()).norm() < 1e-15);
            if direction == Pull::Y {
                assert!((frame.direction(&pull) - Vec3::y()).norm() < 1e-15);
            }
        }
        assert!(Frame::new(Vec3::z(), Vec3::new(0.0, 1.0, 1.0)).is_err());
    }

    #[test]
    fn turns_lower_their_direction() {
        for d in [Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()] {
            let turn = Turn::lowering(d);
            assert_eq!(turn.0 * d, -Vec3::z());
            assert_eq!(turn.0.determinant(), 1.0);
            assert_eq!(turn.inverse().0 * turn.0, Matrix3::identity());
        }
    }
}
