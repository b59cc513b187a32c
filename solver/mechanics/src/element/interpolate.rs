//! From one mesh of a body to another.

use mesh::Vec3;
use mesh::bvh::overlapping_pairs;

use super::basis::{nodes, values};
use super::{FunctionSpace, at};

/// How far outside an element a point may be and still count as in it, relative
/// to the element: rounding, so that points on faces are found.
const MARGIN: f64 = 1e-9;

/// A point of a mesh by barycentric coordinates in an element.
#[derive(Clone, Copy, Debug)]
struct Place {
    element: usize,
    lambda: [f64; 4],
}

impl Place {
    /// The smallest barycentric coordinate: negative outside.
    fn depth(&self) -> f64 {
        self.lambda.into_iter().fold(f64::INFINITY, f64::min)
    }

    fn is_inside(&self) -> bool {
        self.depth() >= -MARGIN
    }
}

/// Interpolates fields of the space `from` at the nodes of the space `to`;
/// rest positions belong to the vertices of the meshes. A node outside
/// all elements takes the nearest one's polynomial, so that the result is
/// meant for nodes in or next to the body.
pub fn interpolate(
    from: &FunctionSpace,
    from_rest: &[Vec3],
    to: &FunctionSpace,
    to_rest: &[Vec3],
    fields: impl Iterator<Item = Vec<f64>>,
) -> Vec<Vec<f64>> {
    let places = places(from, from_rest, &to.node_positions(to_rest));
    let one = |u: Vec<f64>| {
        let value = |place: &Option<Place>| {
            place.as_ref().map_or_else(Vec3::zeros, |place| value(from, &u, place))
        };
        places.iter().flat_map(|place| <[f64; 3]>::from(value(place))).collect()
    };
    fields.map(one).collect()
}

/// A field in the space of a higher degree on the same tetrahedra, which has it exactly.
pub fn elevate(from: &FunctionSpace, to: &FunctionSpace, u: &[f64]) -> Vec<f64> {
    let degree = to.degree() as f64;
    let weights = nodes(4, to.degree()).into_iter().map(|index| {
        let lambda: Vec<f64> = index.iter().map(|&i| i as f64 / degree).collect();
        values(from.degree(), &lambda)
    });
    let weights: Vec<Vec<f64>> = weights.collect();
    let own = from.element_nodes().chunks_exact(from.nodes_per_element());
    let richer = to.element_nodes().chunks_exact(to.nodes_per_element());
    let mut field = vec![0.0; 3 * to.node_count()];
    for (own, richer) in own.zip(richer) {
        for (&node, weights) in richer.iter().zip(&weights) {
            let value: Vec3 = own.iter().zip(weights).map(|(&n, w)| *w * at(u, n)).sum();
            field[3 * node..3 * node + 3].copy_from_slice(value.as_slice());
        }
    }
    field
}

/// Values of the field `u` at rest positions; none at those outside the body.
pub fn sample(
    (space, rest, u): (&FunctionSpace, &[Vec3], &[f64]),
    points: &[Vec3],
) -> Vec<Option<Vec3>> {
    let places = places(space, rest, points).into_iter();
    places.map(|place| place.filter(Place::is_inside).map(|p| value(space, u, &p))).collect()
}

/// Nodes of the element that has a rest position, with the values of their basis there; none
/// outside the body.
pub fn weights(space: &FunctionSpace, rest: &[Vec3], point: Vec3) -> Option<Vec<(usize, f64)>> {
    let place = places(space, rest, &[point]).pop().flatten().filter(Place::is_inside)?;
    Some(weighted_nodes(space, &place).collect())
}

/// The element in which each point lies deepest; none where it is in no
/// element's bounding box.
fn places(space: &FunctionSpace, rest: &[Vec3], points: &[Vec3]) -> Vec<Option<Place>> {
    let boxes: Vec<_> = space.tets().iter().map(|tet| bounds(tet.map(|v| rest[v]))).collect();
    let queries: Vec<_> = points.iter().map(|p| (*p, *p)).collect();
    let mut best: Vec<Option<Place>> = vec![None; points.len()];
    for (point, element) in overlapping_pairs(&queries, &boxes) {
        let lambda = barycentric(space.tets()[element].map(|v| rest[v]), points[point]);
        let place = Place { element, lambda };
        if best[point].is_none_or(|b| place.depth() > b.depth()) {
            best[point] = Some(place);
        }
    }
    best
}

fn value(space: &FunctionSpace, u: &[f64], place: &Place) -> Vec3 {
    weighted_nodes(space, place).map(|(node, value)| value * at(u, node)).sum()
}

/// Nodes of the element of a place, with the values of their basis there.
fn weighted_nodes(space: &FunctionSpace, place: &Place) -> impl Iterator<Item = (usize, f64)> {
    let n = space.nodes_per_element();
    let nodes = &space.element_nodes()[n * place.element..n * (place.element + 1)];
    nodes.iter().copied().zip(values(space.degree(), &place.lambda))
}

/// Bounding box, a little larger so that nodes on its faces are found.
fn bounds(corners: [Vec3; 4]) -> (Vec3, Vec3) {
    let min = corners.iter().fold(corners[0], |m, c| m.inf(c));
    let max = corners.iter().fold(corners[0], |m, c| m.sup(c));
    let margin = MARGIN * (max - min);
    (min - margin, max + margin)
}

fn barycentric([a, b, c, d]: [Vec3; 4], p: Vec3) -> [f64; 4] {
    let volume = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| (b - a).dot(&(c - a).cross(&(d - a)));
    let total = volume(a, b, c, d);
    [volume(p, b, c, d), volume(a, p, c, d), volume(a, b, p, d), volume(a, b, c, p)]
        .map(|v| v / total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    /// A space of degree p holds polynomials of degree p exactly, on any mesh.
    #[test]
    fn polynomials_pass_from_mesh_to_mesh_unchanged() {
        for degree in 1..=3 {
            let [coarse, fine] = [testing::cube(3, 0.2), testing::cube(4, 0.2)];
            let (rest, other_rest) = (coarse.vertices, fine.vertices);
            let from = FunctionSpace::new(degree, rest.len(), coarse.tets);
            let to = FunctionSpace::new(degree, other_rest.len(), fine.tets);
            let p = degree as i32;
            let field = |x: &Vec3| {
                [(x.x + x.y - x.z).powi(p), 0.5 + x.z.powi(p), x.x.powi(p - 1) * (2.0 - x.y)]
            };
            let nodal = |space: &FunctionSpace, rest: &[Vec3]| -> Vec<f64> {
                space.node_positions(rest).iter().flat_map(field).collect()
            };
            let u = nodal(&from, &rest);
            let fields = [vec![0.0; u.len()], u].into_iter();
            let result = interpolate(&from, &rest, &to, &other_rest, fields);
            assert!(result[0].iter().all(|a| *a == 0.0));
            for (a, b) in result[1].iter().zip(nodal(&to, &other_rest)) {
                assert!((a - b).abs() < 1e-12, "{degree} {a} {b}");
            }
        }
    }

    #[test]
    fn a_higher_degree_has_the_same_polynomial() {
        let mesh = testing::cube(2, 0.2);
        let rest = &mesh.vertices;
        for (degree, higher) in [(1, 2), (1, 3), (2, 3)] {
            let space = |degree| FunctionSpace::new(degree, rest.len(), mesh.tets.clone());
            let p = degree as i32;
            let field = |x: &Vec3| [(x.x - 2.0 * x.z).powi(p), x.y.powi(p) + 1.0, x.z];
            let nodal = |space: &FunctionSpace| -> Vec<f64> {
                space.node_positions(rest).iter().flat_map(field).collect()
            };
            let (from, to) = (space(degree), space(higher));
            for (a, b) in elevate(&from, &to, &nodal(&from)).iter().zip(nodal(&to)) {
                assert!((a - b).abs() < 1e-13, "{degree} {higher}: {a} {b}");
            }
        }
    }

    #[test]
    fn points_outside_have_no_value() {
        let mesh = testing::cube(2, 0.2);
        let space = FunctionSpace::new(1, mesh.vertices.len(), mesh.tets);
        let u: Vec<f64> = mesh.vertices.iter().flat_map(|x| [2.0 * x.x, x.y, 0.0]).collect();
        let points = [[0.3, 0.4, 0.5], [1.0, 1.0, 0.2], [1.001, 0.5, 0.5], [9.0, 0.0, 0.0]];
        let found = sample((&space, &mesh.vertices, &u), &points.map(Vec3::from));
        for (point, value) in points.iter().zip(&found[..2]) {
            let expected = Vec3::new(2.0 * point[0], point[1], 0.0);
            assert!((value.expect("inside") - expected).norm() < 1e-14);
        }
        assert_eq!(found[2..], [None, None]);
    }
}
