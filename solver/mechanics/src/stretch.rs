//! Principal stretches of a state against the range a material was fitted to, and against
//! the stretch at which it tears.
//!
//! The stretches λᵢ are the singular values of F = I + ∇u at the quadrature
//! points. A law is extrapolated where the largest one exceeds the largest
//! stretch of its data. Compression needs no test of its own: a body that keeps
//! its volume is stretched by λ^−½ or more where it is squeezed to λ. It is compared with
//! the uniaxial stretch at break, too: what a datasheet has, although a notch or a biaxial state
//! tears earlier.

use mesh::Vec3;
use serde::Serialize;

use crate::element::FunctionSpace;
use crate::material::Kinematics;
use crate::math::tensor::Mat3;
use crate::parallel::fill;

/// How far a material may be stretched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Limits {
    /// Range that it was fitted to [1], if it is known.
    pub fitted: Option<[f64; 2]>,
    /// Uniaxial stretch at which it tears [1], if it is known.
    pub at_break: Option<f64>,
}

/// How far a state strains its material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stretches {
    /// Smallest principal stretch of a quadrature point [1].
    pub smallest: f64,
    /// Largest principal stretch of a quadrature point [1].
    pub largest: f64,
    /// Rest centre of the tetrahedron of the largest [m].
    pub largest_at: [f64; 3],
    /// Rest volume of the tetrahedra with a quadrature point beyond the fitted
    /// range, as a fraction of the body [1].
    pub volume_beyond: f64,
    /// Stretch at break over the largest stretch [1], if it is known: it tears below 1.
    pub margin: Option<f64>,
    /// What the material allows.
    #[serde(flatten)]
    pub limits: Limits,
}

impl Stretches {
    /// Stretches at the displacement u.
    #[must_use]
    pub fn of(space: &FunctionSpace, rest: &[Vec3], u: &[f64], limits: Limits) -> Self {
        let mut found = Self {
            smallest: 1.0,
            largest: 1.0,
            largest_at: [0.0; 3],
            volume_beyond: 0.0,
            margin: None,
            limits,
        };
        let limit = limits.fitted.map_or(f64::INFINITY, |[_, high]| high);
        let mut volume = 0.0;
        let edges = |e: usize| {
            let [a, b, c, d] = space.tets()[e].map(|v| rest[v]);
            (Mat3::from_columns(&[b - a, c - a, d - a]), (a + b + c + d) / 4.0)
        };
        let ranges = fill(space.tets().len(), 1, [1.0; 2], |range, ranges| {
            for (e, own) in range.zip(ranges) {
                *own = element(space.displacement_gradients(rest, u, e));
            }
        });
        for (e, [low, high]) in ranges.into_iter().enumerate() {
            let (g, centre) = edges(e);
            volume += g.determinant();
            found.smallest = found.smallest.min(low);
            if high > limit {
                found.volume_beyond += g.determinant();
            }
            if high > found.largest {
                found.largest = high;
                found.largest_at = centre.into();
            }
        }
        found.volume_beyond /= volume;
        found.margin = limits.at_break.map(|at_break| at_break / found.largest);
        found
    }

    /// The warnings for the user.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let [x, y, z] = self.largest_at;
        let largest =
            format!("largest principal stretch {:.3} at ({x:.5}, {y:.5}, {z:.5}) m", self.largest);
        let extrapolated = self.limits.fitted.filter(|[_, high]| self.largest > *high);
        let torn = self.limits.at_break.filter(|at_break| self.largest >= *at_break);
        let extrapolated = extrapolated.map(|[_, high]| {
            format!(
                "{largest}: the material was fitted up to {high:.3}, and {:.3} % of the body is \
                 beyond\n  what is computed there is an extrapolation: test the silicone further, \
                 or lower the load",
                100.0 * self.volume_beyond
            )
        });
        let torn = torn.map(|at_break| {
            format!("{largest}: the silicone tears at {at_break:.3}: lower the load, or thicken the wall")
        });
        extrapolated.into_iter().chain(torn).collect()
    }
}

/// Smallest and largest principal stretch of one element, by ∇u at its quadrature points.
fn element(gradients: impl Iterator<Item = Mat3>) -> [f64; 2] {
    let mut range = [1.0_f64, 1.0];
    for grad_u in gradients {
        let squares = Kinematics::new(&grad_u).left_minus_1().symmetric_eigenvalues();
        range[0] = range[0].min((1.0 + squares.min()).max(0.0).sqrt());
        range[1] = range[1].max((1.0 + squares.max()).sqrt());
    }
    range
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cube;

    fn limits(at_break: Option<f64>) -> Limits {
        Limits { fitted: Some([1.0, 2.0]), at_break }
    }

    /// The displacement of a homogeneous deformation.
    fn homogeneous(f: &Mat3) -> (FunctionSpace, Vec<Vec3>, Vec<f64>) {
        let mesh = cube(2, 0.2);
        let space = FunctionSpace::new(2, mesh.vertices.len(), mesh.tets.clone());
        let positions = space.node_positions(&mesh.vertices);
        let u = positions
            .iter()
            .flat_map(|x| {
                let u = (f - Mat3::identity()) * x;
                [u.x, u.y, u.z]
            })
            .collect();
        (space, mesh.vertices, u)
    }

    #[test]
    fn principal_stretches_are_found_whatever_the_rotation() {
        let q = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let f = q * Mat3::from_diagonal(&Vec3::new(2.5, 0.9, 0.45)) * q * q;
        let (space, rest, u) = homogeneous(&f);
        let found = Stretches::of(&space, &rest, &u, limits(Some(2.2)));
        assert!((found.largest - 2.5).abs() < 1e-12 && (found.smallest - 0.45).abs() < 1e-12);
        assert!((found.volume_beyond - 1.0).abs() < 1e-12);
        assert!((found.margin.expect("it is known") - 2.2 / 2.5).abs() < 1e-12);
        let [extrapolated, torn] = &found.warnings()[..] else { panic!("{:?}", found.warnings()) };
        assert!(extrapolated.contains("2.500") && extrapolated.contains("up to 2.000"));
        assert!(torn.contains("tears at 2.200"), "{torn}");
    }

    #[test]
    fn within_the_range_nothing_is_said() {
        let (space, rest, u) = homogeneous(&Mat3::from_diagonal(&Vec3::new(1.5, 1.0, 0.7)));
        let found = Stretches::of(&space, &rest, &u, limits(Some(8.0)));
        assert_eq!((found.warnings(), found.volume_beyond), (Vec::new(), 0.0));
        let unknown = Stretches::of(&space, &rest, &u, Limits::default());
        assert_eq!((unknown.warnings(), unknown.margin), (Vec::new(), None));
    }
}
