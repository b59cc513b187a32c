//! Strains and stresses of a state, for ParaView.
//!
//! With F = I + ∇u, J = det F and P = ∂ψ/∂F of the law at a quadrature point, with mean dilatation
//! its pressure in place of U'(J):
//!
//! | name | is | unit |
//! |-|-|-|
//! | `stretch` | largest principal stretch, the largest singular value of F | 1 |
//! | `von_mises` | √(3/2 s : s), s the deviator of σ | Pa |
//! | `hydrostatic_pressure` | −tr σ / 3 | Pa |
//! | `nominal_stress` | largest singular value of P: force per rest area | Pa |
//! | `strain_energy` | ψ, per rest volume | J/m³ |
//! | `cauchy_stress`, cells only | σ = P Fᵀ / J, by rows | Pa |
//!
//! A cell has the mean over its rest volume. A node has the mean over its elements, weighted
//! by its Bernstein polynomial Π λ_k^{i_k}. Such weights are positive, so that no value at a
//! node lies outside those at quadrature points; the basis functions, which are negative in
//! places, would overshoot.

use mesh::Vec3;
use mesh::io::vtu::Field;

use crate::element::{FunctionSpace, node_indices};
use crate::energy::{Elastic, ElementLaw, Energies, Iterate};
use crate::material::Kinematics;
use crate::math::tensor::{Mat3, largest_eigenvalue};
use crate::parallel::fill;

/// Names and units of the scalars, in the order of [`Point::scalars`].
const SCALARS: [(&str, &str); 5] = [
    ("stretch", "1"),
    ("von_mises", "Pa"),
    ("hydrostatic_pressure", "Pa"),
    ("nominal_stress", "Pa"),
    ("strain_energy", "J/m³"),
];

/// What is known at a quadrature point, or the mean of it over a cell.
#[derive(Clone, Copy, Default)]
struct Point {
    scalars: [f64; SCALARS.len()],
    cauchy: Mat3,
}

impl Point {
    fn new(law: &ElementLaw, q: usize, grad_u: &Mat3) -> Self {
        let k = Kinematics::new(grad_u);
        let p = law.first_piola(q, &k);
        let cauchy = p * k.f.transpose() / k.j();
        let pressure = -cauchy.trace() / 3.0;
        let deviator = cauchy + pressure * Mat3::identity();
        let scalars = [
            (1.0 + largest_eigenvalue(&k.left_minus_1())).sqrt(),
            1.5_f64.sqrt() * deviator.norm(),
            pressure,
            largest_eigenvalue(&(p * p.transpose())).max(0.0).sqrt(),
            law.energy_density(&k),
        ];
        Self { scalars, cauchy }
    }

    fn add(&mut self, weight: f64, other: &Self) {
        self.cauchy += weight * other.cauchy;
        self.scalars.iter_mut().zip(&other.scalars).for_each(|(sum, x)| *sum += weight * x);
    }
}

/// Fields at the points, and of the cells.
pub fn fields(energies: &Energies, at: &Iterate) -> [Vec<Field>; 2] {
    let space = at.space;
    let quadrature = space.volume_table().weights.len();
    let mut points = vec![Point::default(); space.tets().len() * quadrature];
    for elastic in energies.each::<Elastic>() {
        let elements = elastic.elements(space);
        let first = elements.start;
        let own = fill(elements.len(), quadrature, Point::default(), |range, points| {
            for (e, points) in range.zip(points.chunks_exact_mut(quadrature)) {
                let law = elastic.law_in(at, first + e);
                let gradients = space.displacement_gradients(at.rest, at.u, first + e);
                for (q, (point, grad_u)) in points.iter_mut().zip(gradients).enumerate() {
                    *point = Point::new(&law, q, &grad_u);
                }
            }
        });
        points[first * quadrature..][..own.len()].copy_from_slice(&own);
    }
    let cells = means(space, &points);
    let cauchy = cells.iter().flat_map(|cell| cell.cauchy.transpose().as_slice().to_vec());
    let tensor = Field::new("cauchy_stress", "Pa", 9, cauchy.collect());
    let of_cells = scalars(&cells).chain([tensor]).collect();
    [scalars(&at_nodes(at, &points)).collect(), of_cells]
}

/// J at the quadrature points of an element.
pub fn volume_ratios(space: &FunctionSpace, rest: &[Vec3], u: &[f64], element: usize) -> Vec<f64> {
    let gradients = space.displacement_gradients(rest, u, element);
    gradients.map(|grad_u| Kinematics::new(&grad_u).j()).collect()
}

/// Means over each cell.
fn means(space: &FunctionSpace, points: &[Point]) -> Vec<Point> {
    let weights = &space.volume_table().weights;
    let mean = |points: &[Point]| {
        let mut mean = Point::default();
        weights.iter().zip(points).for_each(|(&weight, point)| mean.add(weight, point));
        mean
    };
    points.chunks_exact(weights.len()).map(mean).collect()
}

/// Means around each node.
fn at_nodes(at: &Iterate, points: &[Point]) -> Vec<Point> {
    let (space, table) = (at.space, at.space.volume_table());
    let indices = node_indices(4, space.degree());
    let bernstein = |lambda: &Vec<f64>| -> Vec<f64> {
        let one = |index: &Vec<usize>| -> f64 {
            index.iter().zip(lambda).map(|(&i, l)| l.powi(i as i32)).product()
        };
        indices.iter().map(one).collect()
    };
    let polynomials: Vec<Vec<f64>> = table.points.iter().map(bernstein).collect();
    let mut sums = vec![(0.0, Point::default()); space.node_count()];
    let elements = space.element_nodes().chunks_exact(indices.len());
    let own_points = points.chunks_exact(table.weights.len());
    for ((tet, nodes), points) in space.tets().iter().zip(elements).zip(own_points) {
        let [a, b, c, d] = tet.map(|v| at.rest[v]);
        let volume = mesh::measure::tet_volume(a, b, c, d);
        for ((point, weight), polynomials) in points.iter().zip(&table.weights).zip(&polynomials) {
            for (&node, polynomial) in nodes.iter().zip(polynomials) {
                let weight = volume * weight * polynomial;
                sums[node].0 += weight;
                sums[node].1.add(weight, point);
            }
        }
    }
    let mean = |(weight, sum): (f64, Point)| {
        let mut mean = Point::default();
        mean.add(1.0 / weight, &sum);
        mean
    };
    sums.into_iter().map(mean).collect()
}

fn scalars(points: &[Point]) -> impl Iterator<Item = Field> {
    SCALARS.into_iter().enumerate().map(|(i, (name, unit))| {
        Field::new(name, unit, 1, points.iter().map(|point| point.scalars[i]).collect())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Lame, NeoHookean};
    use crate::testing::cube;

    /// Fields of a cube of neo-Hookean material that is displaced as a function says.
    fn fields_of(degree: usize, u: impl Fn(Vec3) -> Vec3) -> [Vec<Field>; 2] {
        let mesh = cube(2, 0.2);
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
        let nodes = space.node_positions(&mesh.vertices);
        let u: Vec<f64> = nodes.iter().flat_map(|&x| u(x).data.0[0]).collect();
        let energies = Energies::elastic(Box::new(NeoHookean(law())));
        let at = Iterate::new(&space, &mesh.vertices, &u, 1.0);
        fields(&energies, &at)
    }

    fn law() -> Lame {
        Lame::new(1.5e5, 0.45)
    }

    #[test]
    fn a_homogeneous_deformation_has_its_stress_everywhere() {
        let q = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let stretches = Vec3::new(2.0, 0.9, 0.5);
        let f = q * Mat3::from_diagonal(&stretches);
        let j = stretches.product();
        let Lame { mu, lambda, .. } = law();
        let tau = mu * (stretches.component_mul(&stretches)).add_scalar(-1.0);
        let principal = tau.add_scalar(lambda * j.ln()) / j;
        let cauchy = q * Mat3::from_diagonal(&principal) * q.transpose();
        let spread = |i: usize, k: usize| (principal[i] - principal[k]).powi(2);
        let expected = [
            ("stretch", 2.0),
            ("von_mises", (0.5 * (spread(0, 1) + spread(1, 2) + spread(2, 0))).sqrt()),
            ("hydrostatic_pressure", -principal.mean()),
            ("nominal_stress", (j * principal.component_div(&stretches)).amax()),
            ("strain_energy", 0.5 * tau.sum() - mu * j.ln() + 0.5 * lambda * j.ln().powi(2)),
        ];
        for degree in 1..=3 {
            let [points, cells] = fields_of(degree, |x| (f - Mat3::identity()) * x);
            for (name, expected) in expected {
                for fields in [&points, &cells] {
                    let field =
                        fields.iter().find(|field| field.name == name).expect("it is written");
                    let near = |x: &f64| (x - expected).abs() < 1e-9 * expected.abs();
                    assert!(field.values.iter().all(near), "{name} {expected} {:?}", field.values);
                }
            }
            let tensor =
                cells.iter().find(|field| field.name == "cauchy_stress").expect("it is written");
            for found in tensor.values.chunks_exact(9) {
                let error = (Mat3::from_row_slice(found) - cauchy).norm();
                assert!(error < 1e-9 * cauchy.norm(), "{found:?}");
            }
        }
    }

    #[test]
    fn what_varies_linearly_is_exact_in_cells_and_within_its_range_at_nodes() {
        // I + ∇u = diag(1 + x, 1, 1): the largest stretch is 1 + x
        let [points, cells] = fields_of(2, |x| Vec3::new(0.5 * x.x * x.x, 0.0, 0.0));
        let mesh = cube(2, 0.2);
        for (tet, stretch) in mesh.tets.iter().zip(&cells[0].values) {
            let centre = tet.map(|v| mesh.vertices[v].x).iter().sum::<f64>() / 4.0;
            assert!((stretch - 1.0 - centre).abs() < 1e-12, "{stretch} {centre}");
        }
        let stretches = &points[0].values;
        assert!(stretches.iter().all(|s| (1.0..=2.0).contains(s)), "{stretches:?}");
    }
}
