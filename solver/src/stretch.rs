//! Principal stretches of a state against the range a material was fitted to.
//!
//! The stretches λᵢ are the singular values of F = I + ∇u at the quadrature
//! points. A law is extrapolated where the largest one exceeds the largest
//! stretch of its data. Compression needs no test of its own: a body that keeps
//! its volume is stretched by λ^−½ or more where it is squeezed to λ.

use mesh::Vec3;
use serde::Serialize;

use crate::element::{FunctionSpace, at};
use crate::material::Kinematics;
use crate::math::tensor::{Mat3, cofactor};
use crate::parallel::fill;

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
    /// Range that the material was fitted to [1], if it is known.
    pub fitted: Option<[f64; 2]>,
}

impl Stretches {
    /// Of the displacement u.
    #[must_use]
    pub fn of(space: &FunctionSpace, rest: &[Vec3], u: &[f64], fitted: Option<[f64; 2]>) -> Self {
        let mut found =
            Self { smallest: 1.0, largest: 1.0, largest_at: [0.0; 3], volume_beyond: 0.0, fitted };
        let limit = fitted.map_or(f64::INFINITY, |[_, high]| high);
        let mut volume = 0.0;
        let n = space.nodes_per_element();
        let edges = |e: usize| {
            let [a, b, c, d] = space.tets()[e].map(|v| rest[v]);
            (Mat3::from_columns(&[b - a, c - a, d - a]), (a + b + c + d) / 4.0)
        };
        let ranges = fill(space.tets().len(), 1, [1.0; 2], |range, ranges| {
            for (e, own) in range.zip(ranges) {
                let (g, _) = edges(e);
                let nodes = &space.element_nodes()[e * n..(e + 1) * n];
                *own = element(space, &(cofactor(&g) / g.determinant()), nodes, u);
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
        found
    }

    /// The warning for the user, if any.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let [_, high] = self.fitted.filter(|[_, high]| self.largest > *high)?;
        let [x, y, z] = self.largest_at;
        Some(format!(
            "largest principal stretch {:.3} at ({x:.5}, {y:.5}, {z:.5}) m: the material was fitted \
             up to {high:.3}, and {:.3} % of the body is beyond\n  what is computed there is an \
             extrapolation: test the silicone further, or lower the load",
            self.largest,
            100.0 * self.volume_beyond
        ))
    }
}

/// Smallest and largest principal stretch of one element.
fn element(space: &FunctionSpace, to_rest: &Mat3, nodes: &[usize], u: &[f64]) -> [f64; 2] {
    let mut range = [1.0_f64, 1.0];
    for gradients in &space.volume_table().gradients {
        let mut grad_u = Mat3::zeros();
        for (&node, gradient) in nodes.iter().zip(gradients) {
            grad_u += at(u, node) * (to_rest * Vec3::from(*gradient)).transpose();
        }
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
        let found = Stretches::of(&space, &rest, &u, Some([1.0, 2.0]));
        assert!((found.largest - 2.5).abs() < 1e-12 && (found.smallest - 0.45).abs() < 1e-12);
        assert!((found.volume_beyond - 1.0).abs() < 1e-12);
        let warning = found.warning().expect("2.5 is more than 2");
        assert!(warning.contains("2.500") && warning.contains("up to 2.000"), "{warning}");
    }

    #[test]
    fn within_the_range_nothing_is_said() {
        let (space, rest, u) = homogeneous(&Mat3::from_diagonal(&Vec3::new(1.5, 1.0, 0.7)));
        let found = Stretches::of(&space, &rest, &u, Some([1.0, 2.0]));
        assert_eq!((found.warning(), found.volume_beyond), (None, 0.0));
        assert_eq!(Stretches::of(&space, &rest, &u, None).warning(), None);
    }
}
