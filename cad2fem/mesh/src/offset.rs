//! Walls that are off: vertices moved so that their facets move along their normals.
//!
//! d minimises Σ w (n·d − 1)² over the facets at a vertex     move per distance [1]
//!
//! n    outward unit normal of a facet; w its angle at the vertex
//!
//! On a smooth surface d is the normal, at an edge both sides move by the distance. Quadric
//! errors as in Garland and Heckbert 1997.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, SymmetricEigen};

use crate::{Vec3, measure};

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

    #[test]
    fn all_faces_of_a_cube_move_by_the_distance() {
        let corner = |v: usize| Vec3::from_fn(|k, _| (v >> k & 1) as f64);
        let corners: Vec<Vec3> = (0..8).map(corner).collect();
        let squares =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let facets: Vec<[usize; 3]> =
            squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let moves = shifts(&corners, &facets);
        assert_eq!(moves.len(), 8);
        for (v, d) in moves {
            assert!((d - (2.0 * corners[v] - Vec3::repeat(1.0))).norm() < 1e-12, "{v}: {d:?}");
        }
    }
}
