//! Directions of fibres: unit vectors a₀(X) by a formula of the rest position.
//!
//! About an axis through p along the unit vector k, with the part r of X − p across it, ρ = |r|:
//!
//! e_r = r/ρ      e_θ = k × e_r      helical: a₀ = cos α k + sin α e_θ      radial: a₀ = e_r
//! ∂e_r/∂X = e_θ ⊗ e_θ/ρ              ∂a₀/∂X = −sin α e_r ⊗ e_θ/ρ
//!
//! α = 0 is along the axis, 90° around it; a positive α is a right-handed screw. The formula is in space: a
//! designed rest shape moves through it, and derivatives by the rest shape have ∂a₀/∂X.

use std::ops::Range;

use mesh::Vec3;

use crate::element::FunctionSpace;
use crate::math::tensor::Mat3;

/// Part of an element's size that is rounding.
const MARGIN: f64 = 1e-9;

/// A line in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// A point on it [m].
    pub point: Vec3,
    /// The unit vector along it.
    pub along: Vec3,
}

/// A direction field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// One unit vector everywhere.
    Constant(Vec3),
    /// Around an axis at an angle to it [rad].
    Helical(Axis, f64),
    /// Away from an axis.
    Radial(Axis),
}

/// What lies around an axis at a point: e_r, e_θ and ρ [m].
struct Around {
    radial: Vec3,
    hoop: Vec3,
    distance: f64,
}

impl Axis {
    fn around(&self, x: Vec3) -> Around {
        let from = x - self.point;
        let across = from - from.dot(&self.along) * self.along;
        let distance = across.norm();
        let radial = across / distance;
        Around { radial, hoop: self.along.cross(&radial), distance }
    }

    /// A point on the axis inside one of some elements, or on the boundary of one.
    pub fn point_inside(
        &self,
        space: &FunctionSpace,
        rest: &[Vec3],
        elements: Range<usize>,
    ) -> Option<Vec3> {
        let passes = |tet: &&[usize; 4]| self.passes(tet.map(|v| rest[v]));
        let tet = space.tets()[elements].iter().find(passes)?;
        let centre = tet.iter().map(|&v| rest[v]).sum::<Vec3>() / 4.0;
        Some(self.point + (centre - self.point).dot(&self.along) * self.along)
    }

    /// Whether it passes a tetrahedron: seen along the axis, a facet has it in its triangle. Facets that are
    /// seen from the side are left out: the others cover the same.
    fn passes(&self, corners: [Vec3; 4]) -> bool {
        let from = corners.map(|x| x - self.point);
        let area = |a: usize, b: usize| self.along.dot(&from[a].cross(&from[b]));
        mesh::topology::TET_FACETS.iter().any(|&[a, b, c]| {
            let parts = [area(a, b), area(b, c), area(c, a)];
            let whole: f64 = parts.iter().sum();
            let size = (from[b] - from[a]).norm_squared() + (from[c] - from[a]).norm_squared();
            whole.abs() > MARGIN * size && parts.iter().all(|part| part / whole >= -MARGIN)
        })
    }
}

impl Direction {
    /// a₀ at a rest position; not a number on the axis.
    pub fn at(&self, x: Vec3) -> Vec3 {
        match self {
            Self::Constant(along) => *along,
            Self::Helical(axis, angle) if *angle == 0.0 => axis.along,
            Self::Helical(axis, angle) => {
                angle.cos() * axis.along + angle.sin() * axis.around(x).hoop
            }
            Self::Radial(axis) => axis.around(x).radial,
        }
    }

    /// ∂a₀/∂X [1/m].
    pub fn gradient(&self, x: Vec3) -> Mat3 {
        match self {
            Self::Constant(_) => Mat3::zeros(),
            Self::Helical(_, angle) if *angle == 0.0 => Mat3::zeros(),
            Self::Helical(axis, angle) => {
                let Around { radial, hoop, distance } = axis.around(x);
                -(angle.sin() / distance) * radial * hoop.transpose()
            }
            Self::Radial(axis) => {
                let Around { hoop, distance, .. } = axis.around(x);
                hoop * hoop.transpose() / distance
            }
        }
    }

    /// ∂a₀/∂α [1/rad]; zero where there is no angle.
    pub fn by_angle(&self, x: Vec3) -> Vec3 {
        let Self::Helical(axis, angle) = self else { return Vec3::zeros() };
        angle.cos() * axis.around(x).hoop - angle.sin() * axis.along
    }

    /// The axis that it needs, where it is undefined.
    pub fn axis(&self) -> Option<&Axis> {
        match self {
            Self::Constant(_) => None,
            Self::Helical(_, angle) if *angle == 0.0 => None,
            Self::Helical(axis, _) | Self::Radial(axis) => Some(axis),
        }
    }

    /// Whether it is the same everywhere.
    pub fn is_constant(&self) -> bool {
        self.axis().is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cube;

    /// About z at (1, 0, 0): the axis, y, and between both a right-handed screw.
    #[test]
    fn angles_are_from_the_axis_and_right_handed() {
        let axis = Axis { point: Vec3::zeros(), along: Vec3::z() };
        let at = |degrees: f64| Direction::Helical(axis, degrees.to_radians()).at(Vec3::x());
        assert_eq!(at(0.0), Vec3::z());
        assert!((at(90.0) - Vec3::y()).norm() < 1e-15);
        assert!((at(30.0) - Vec3::new(0.0, 0.5, 0.75_f64.sqrt())).norm() < 1e-15);
        assert_eq!(Direction::Radial(axis).at(2.0 * Vec3::y()), Vec3::y());
        let oblique =
            Axis { point: Vec3::new(0.3, -0.2, 0.1), along: Vec3::new(1.0, 2.0, 2.0) / 3.0 };
        for direction in [Direction::Helical(oblique, 0.7), Direction::Radial(oblique)] {
            assert!((direction.at(Vec3::new(0.9, 0.4, -0.6)).norm() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn an_axis_inside_is_found() {
        let mesh = cube(2, 0.1);
        let space = FunctionSpace::new(1, mesh.vertices.len(), mesh.tets.clone());
        let find = |x: f64, y: f64| {
            let axis = Axis { point: Vec3::new(x, y, -3.0), along: Vec3::z() };
            axis.point_inside(&space, &mesh.vertices, 0..mesh.tets.len())
        };
        for (x, y) in [(0.3, 0.6), (0.0, 0.4), (1.0, 1.0), (0.5, 0.5)] {
            let place = find(x, y).expect("it passes");
            assert!(place.x == x && place.y == y && (0.0..1.0).contains(&place.z), "{place}");
        }
        // beside the body; beyond its sides, in their planes
        for (x, y) in [(-0.001, 0.4), (1.2, 1.2), (0.5, 1.01), (0.0, 1.3), (1.0, -0.1)] {
            assert_eq!(find(x, y), None, "{x} {y}");
        }
    }
}
