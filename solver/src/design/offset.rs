//! Walls that are off: vertices moved so that their facets move along their normals.
//!
//! d minimises Σ w (n·d − 1)² over the facets at a vertex     move per distance [1]
//!
//! n    outward unit normal of a facet; w its angle at the vertex
//!
//! On a smooth surface d is the normal, at an edge both sides move by the distance. Quadric
//! errors as in Garland and Heckbert 1997; `fab` moves walls by the same formula.

use std::collections::BTreeMap;

use mesh::{Vec3, measure};
use nalgebra::{Matrix3, SymmetricEigen};

/// Directions in which normals vary by less than this part of the most are not moved in:
/// normals within 20° count as one.
const FLAT: f64 = 0.03;

/// Moves per distance of the vertices of facets, which turn their normals outward.
#[must_use]
pub fn shifts(x: &[Vec3], facets: &[[usize; 3]]) -> BTreeMap<usize, Vec3> {
    let mut quadrics: BTreeMap<usize, (Matrix3<f64>, Vec3)> = BTreeMap::new();
    for facet in facets {
        let corners = facet.map(|v| x[v]);
        let normal = measure::triangle_normal(corners[0], corners[1], corners[2]);
        for k in 0..3 {
            let [a, b] = [1, 2].map(|i| corners[(k + i) % 3] - corners[k]);
            let angle = a.angle(&b);
            let (matrix, sum) = quadrics.entry(facet[k]).or_default();
            *matrix += normal * normal.transpose() * angle;
            *sum += normal * angle;
        }
    }
    quadrics.into_iter().map(|(v, (matrix, sum))| (v, least(matrix, &sum))).collect()
}

/// The shortest d with the least error: the pseudo-inverse.
fn least(matrix: Matrix3<f64>, sum: &Vec3) -> Vec3 {
    let SymmetricEigen { eigenvalues, eigenvectors } = matrix.symmetric_eigen();
    let counts = |&k: &usize| eigenvalues[k] > FLAT * eigenvalues.max();
    let along = |k: usize| {
        let axis = eigenvectors.column(k).into_owned();
        axis * (axis.dot(sum) / eigenvalues[k])
    };
    (0..3).filter(counts).map(along).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cube;
    use mesh::topology;

    #[test]
    fn all_faces_of_a_cube_move_by_the_distance() {
        let cube = cube(3, 0.2);
        let moved = shifts(&cube.vertices, &topology::boundary(&cube).facets);
        for (v, d) in moved {
            for k in 0..3 {
                let outward = match cube.vertices[v][k] {
                    x if x < 1e-9 => -1.0,
                    x if x > 1.0 - 1e-9 => 1.0,
                    _ => 0.0,
                };
                assert!((d[k] - outward).abs() < 1e-12, "{v}: {d:?}");
            }
        }
    }
}
