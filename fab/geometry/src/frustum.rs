//! The frustum of a cone, the shape of all round features.

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
    /// One with the same radius all along.
    pub fn cylinder(base: Vec3, axis: Vec3, radius: f64) -> Self {
        Self { base, axis, base_radius: radius, top_radius: radius }
    }

    /// The inscribed polyhedron with [`SEGMENTS`] sides.
    pub fn solid(&self) -> Solid {
        Solid::cylinder(&self.base, &self.axis, self.base_radius, self.top_radius, SEGMENTS)
    }

    /// Distance of a point from the axis [m].
    pub fn from_axis(&self, p: &Vec3) -> f64 {
        let from = p - self.base;
        let along = (from.dot(&self.axis) / self.axis.norm_squared()).clamp(0.0, 1.0);
        (from - self.axis * along).norm()
    }

    /// With both radii larger by `clearance` and longer by it at both ends [m].
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
