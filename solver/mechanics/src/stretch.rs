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

use crate::element::{FunctionSpace, add_at};
use crate::material::Kinematics;
use crate::math::tensor::{Mat3, cofactor};
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

/// The largest principal stretch of a state, that of [`Stretches`], and where it is.
///
/// s = max λ = |F N|,   n = F N / s,   S = n Nᵀ
/// ∂s/∂u_a = S ∇φ_a,   ∂s/∂X_k = −∇uᵀ S ∇ψ_k      at fixed nodal u
///
/// φ   basis of the displacement;   ψ   linear basis of the rest shape
///
/// It is a maximum: where two points, or two principal stretches of one point, have it together, it has a kink, and this
/// is its derivative on one side of that.
#[derive(Clone, Copy, Debug)]
pub struct LargestStretch {
    /// s [1].
    pub value: f64,
    /// Tetrahedron.
    pub element: usize,
    /// Point of its volume rule.
    pub point: usize,
}

impl LargestStretch {
    /// At the displacement u.
    #[must_use]
    pub fn of(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Self {
        let count = space.tets().len();
        let each = fill(count, 1, (f64::NEG_INFINITY, 0), |range, each| {
            for (element, own) in range.zip(each) {
                for (point, grad_u) in space.displacement_gradients(rest, u, element).enumerate() {
                    let [_, high] = principal(&grad_u);
                    if high > own.0 {
                        *own = (high, point);
                    }
                }
            }
        });
        let mut found = Self { value: f64::NEG_INFINITY, element: 0, point: 0 };
        for (element, (value, point)) in each.into_iter().enumerate() {
            if value > found.value {
                found = Self { value, element, point };
            }
        }
        found
    }

    /// ∂s/∂u, three components per node, and ∂s/∂X [1/m], three per vertex.
    #[must_use]
    pub fn partials(
        &self,
        space: &FunctionSpace,
        rest: &[Vec3],
        u: &[f64],
    ) -> (Vec<f64>, Vec<f64>) {
        let Self { element, point, .. } = *self;
        let (mut by_u, mut by_rest) = (vec![0.0; u.len()], vec![0.0; 3 * rest.len()]);
        let Some(grad_u) = space.displacement_gradients(rest, u, element).nth(point) else {
            return (by_u, by_rest);
        };
        let f = Mat3::identity() + grad_u;
        let eigen = (f.transpose() * f).symmetric_eigen();
        let material = eigen.eigenvectors.column(eigen.eigenvalues.imax());
        let spatial = (f * material).normalize();
        let slope = spatial * material.transpose();
        let corners = space.tets()[element];
        let [a, b, c, d] = corners.map(|v| rest[v]);
        let edges = Mat3::from_columns(&[b - a, c - a, d - a]);
        let to_rest = cofactor(&edges) / edges.determinant();
        let n = space.nodes_per_element();
        let nodes = &space.element_nodes()[n * element..n * (element + 1)];
        for (&node, gradient) in nodes.iter().zip(&space.volume_table().gradients[point]) {
            add_at(&mut by_u, node, &(slope * (to_rest * Vec3::from(*gradient))));
        }
        let turned = grad_u.transpose() * slope;
        for (k, &vertex) in corners[1..].iter().enumerate() {
            let by = turned * to_rest.column(k);
            add_at(&mut by_rest, vertex, &-by);
            add_at(&mut by_rest, corners[0], &by);
        }
        (by_u, by_rest)
    }
}

/// Smallest and largest principal stretch at ∇u.
fn principal(grad_u: &Mat3) -> [f64; 2] {
    let squares = Kinematics::new(grad_u).left_minus_1().symmetric_eigenvalues();
    [squares.min(), squares.max()].map(|square| (1.0 + square).max(0.0).sqrt())
}

/// Smallest and largest principal stretch of one element, by ∇u at its quadrature points.
fn element(gradients: impl Iterator<Item = Mat3>) -> [f64; 2] {
    gradients
        .map(|grad_u| principal(&grad_u))
        .fold([1.0, 1.0], |range, [low, high]| [range[0].min(low), range[1].max(high)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::linear::dot;
    use crate::math::random::Random;
    use crate::math::taylor::taylor;
    use crate::testing::{cube, flat};

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

    /// By displacement and by rest shape, with all nodes and vertices moved.
    #[test]
    fn derivatives_of_the_largest_stretch_belong_to_it() {
        for degree in [1, 2, 3] {
            let mesh = cube(2, 0.2);
            let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
            let mut random = Random::new(7);
            let u: Vec<f64> = flat(&random_vectors(&mut random, space.node_count(), 0.01));
            let found = LargestStretch::of(&space, &mesh.vertices, &u);
            let largest = Stretches::of(&space, &mesh.vertices, &u, Limits::default()).largest;
            assert_eq!(found.value, largest);
            let (by_u, by_rest) = found.partials(&space, &mesh.vertices, &u);
            let du = flat(&random_vectors(&mut random, space.node_count(), 1e-4));
            let dx = random_vectors(&mut random, mesh.vertices.len(), 1e-4);
            let slope = dot(&by_u, &du) + dot(&by_rest, &flat(&dx));
            let result = taylor(1.0, 6, slope, |by| {
                let u: Vec<f64> = u.iter().zip(&du).map(|(u, d)| u + by * d).collect();
                let rest: Vec<Vec3> =
                    mesh.vertices.iter().zip(&dx).map(|(x, d)| x + by * d).collect();
                Ok::<_, ()>(LargestStretch::of(&space, &rest, &u).value)
            });
            let result = result.expect("values");
            assert!((result.slope - 2.0).abs() < 0.1, "{degree} {result:?}");
        }
    }

    fn random_vectors(random: &mut Random, count: usize, size: f64) -> Vec<Vec3> {
        (0..count).map(|_| size * random.vector()).collect()
    }
}
