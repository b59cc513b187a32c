//! From one mesh of a body to another.

use mesh::Vec3;
use mesh::bvh::overlapping_pairs;

use super::basis::values;
use super::{FunctionSpace, at};

/// Interpolates the field `u` of the space `from` at the nodes of the space
/// `to`; rest positions belong to the vertices of the meshes. A node outside
/// all elements takes the nearest one's polynomial, so that the result is
/// meant for nodes in or next to the body.
#[must_use]
pub fn interpolate(
    (from, from_rest, u): (&FunctionSpace, &[Vec3], &[f64]),
    (to, to_rest): (&FunctionSpace, &[Vec3]),
) -> Vec<f64> {
    let nodes = to.node_positions(to_rest);
    let boxes: Vec<_> = from.tets().iter().map(|tet| bounds(tet.map(|v| from_rest[v]))).collect();
    let points: Vec<_> = nodes.iter().map(|p| (*p, *p)).collect();
    let mut best = vec![(f64::NEG_INFINITY, 0, [0.0; 4]); nodes.len()];
    for (node, tet) in overlapping_pairs(&points, &boxes) {
        let lambda = barycentric(from.tets()[tet].map(|v| from_rest[v]), nodes[node]);
        let inside = lambda.into_iter().fold(f64::INFINITY, f64::min);
        if inside > best[node].0 {
            best[node] = (inside, tet, lambda);
        }
    }
    let n = from.nodes_per_element();
    let mut result = Vec::with_capacity(3 * nodes.len());
    for (found, tet, lambda) in best {
        let mut sum = Vec3::zeros();
        if found > f64::NEG_INFINITY {
            let element = &from.element_nodes()[n * tet..n * (tet + 1)];
            for (&node, value) in element.iter().zip(values(from.degree(), &lambda)) {
                sum += value * at(u, node);
            }
        }
        result.extend(sum.iter());
    }
    result
}

/// Bounding box, a little larger so that nodes on its faces are found.
fn bounds(corners: [Vec3; 4]) -> (Vec3, Vec3) {
    let min = corners.iter().fold(corners[0], |m, c| m.inf(c));
    let max = corners.iter().fold(corners[0], |m, c| m.sup(c));
    let margin = 1e-9 * (max - min);
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
            let sample = |space: &FunctionSpace, rest: &[Vec3]| -> Vec<f64> {
                space.node_positions(rest).iter().flat_map(field).collect()
            };
            let u = sample(&from, &rest);
            let result = interpolate((&from, &rest, &u), (&to, &other_rest));
            for (a, b) in result.iter().zip(sample(&to, &other_rest)) {
                assert!((a - b).abs() < 1e-12, "{degree} {a} {b}");
            }
        }
    }
}
