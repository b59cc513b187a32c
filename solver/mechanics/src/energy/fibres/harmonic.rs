//! Directions from a potential, as cardiac mechanics makes them: along ∇φ of the harmonic function between two surfaces.
//!
//! Δφ = 0 in some elements, φ = 0 and φ = 1 at the vertices of two surfaces, ∂φ/∂n = 0 elsewhere
//!
//! by linear elements: Σ_T |T| ∇ψ_a · ∇ψ_b φ_b = 0 at every other vertex a, with the hat functions ψ.
//!
//! Source: Bayer, Blake, Plank and Trayanova 2012, "A novel rule-based algorithm for assigning myocardial fiber
//! orientation", doi:10.1007/s10439-012-0593-5.

use std::collections::BTreeMap;

use mesh::Vec3;

use crate::math::linear::{NotPositive, Precision, SparseSolver, Symmetric, one_by_one};
use crate::math::ordering::nested_dissection;
use crate::math::tensor::Mat3;

/// ∇φ of every element [1/m], with φ = 0 and φ = 1 at the given vertices; at a vertex of both φ is 0. It is zero in
/// elements that are connected with neither.
pub fn gradients_of_potential(
    tets: &[[usize; 4]],
    x: &[Vec3],
    [zero, one]: [&[usize]; 2],
) -> Result<Vec<Vec3>, NotPositive> {
    let mut given: BTreeMap<usize, f64> = one.iter().map(|&v| (v, 1.0)).collect();
    given.extend(zero.iter().map(|&v| (v, 0.0)));
    let mut unknown = BTreeMap::new();
    for v in tets.iter().flatten().filter(|v| !given.contains_key(v)) {
        unknown.insert(*v, 0);
    }
    unknown.values_mut().enumerate().for_each(|(i, place)| *place = i);
    let gradients: Vec<[Vec3; 4]> = tets.iter().map(|tet| hats(tet.map(|v| x[v]))).collect();
    let values = solve(tets, x, &gradients, (&given, &unknown))?;
    let at = |v: &usize| given.get(v).copied().unwrap_or_else(|| values[unknown[v]]);
    let one = |(tet, hats): (&[usize; 4], &[Vec3; 4])| {
        tet.iter().zip(hats).map(|(v, hat)| at(v) * hat).sum()
    };
    Ok(tets.iter().zip(&gradients).map(one).collect())
}

/// ∇ψ of the corners of a tetrahedron [1/m].
fn hats(x: [Vec3; 4]) -> [Vec3; 4] {
    let edges = Mat3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]]);
    let rows = edges.try_inverse().unwrap_or_else(Mat3::zeros);
    let [a, b, c] = [0, 1, 2].map(|k| rows.row(k).transpose());
    [-(a + b + c), a, b, c]
}

fn volume(x: [Vec3; 4]) -> f64 {
    (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0])).abs() / 6.0
}

/// φ at the unknown vertices.
fn solve(
    tets: &[[usize; 4]],
    x: &[Vec3],
    gradients: &[[Vec3; 4]],
    (given, unknown): (&BTreeMap<usize, f64>, &BTreeMap<usize, usize>),
) -> Result<Vec<f64>, NotPositive> {
    let n = unknown.len();
    let mut columns: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); n];
    let mut b = vec![0.0; n];
    for (tet, hats) in tets.iter().zip(gradients) {
        let size = volume(tet.map(|v| x[v]));
        for (v, hat) in tet.iter().zip(hats) {
            let Some(&row) = unknown.get(v) else { continue };
            for (w, other) in tet.iter().zip(hats) {
                let entry = size * hat.dot(other);
                match unknown.get(w) {
                    Some(&column) if column <= row => {
                        *columns[column].entry(row).or_insert(0.0) += entry;
                    }
                    Some(_) => {}
                    None => b[row] -= entry * given[w],
                }
            }
        }
    }
    let (mut start, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut adjacency = vec![Vec::new(); n];
    for (column, entries) in columns.iter().enumerate() {
        for (&row, &value) in entries {
            rows.push(row);
            values.push(value);
            if row != column {
                adjacency[row].push(column);
                adjacency[column].push(row);
            }
        }
        start.push(rows.len());
    }
    let solver = SparseSolver::new(start, &rows, &one_by_one(&nested_dissection(&adjacency)));
    let factored = solver.positive(Symmetric::sparse(values), Precision::Double)?;
    factored.solve(&mut b);
    Ok(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cube;

    /// Between two faces of a cube φ is linear, and in a quarter of a ring, between its cut faces, φ = 2θ/π.
    #[test]
    fn potentials_between_faces_are_those_of_their_closed_forms() {
        let mut mesh = cube(12, 0.0);
        let on = |mesh: &mesh::TetMesh, level: f64| -> Vec<usize> {
            (0..mesh.vertices.len()).filter(|&v| mesh.vertices[v].y == level).collect()
        };
        let (zero, one) = (on(&mesh, 0.0), on(&mesh, 1.0));
        let found = gradients_of_potential(&mesh.tets, &mesh.vertices, [&zero, &one]);
        let found = found.expect("a cube is connected");
        assert!(found.iter().all(|g| (g - Vec3::y()).norm() < 1e-12));
        for x in &mut mesh.vertices {
            let (sin, cos) = (0.5 * std::f64::consts::PI * x.y).sin_cos();
            *x = Vec3::new((2.0 + x.x) * cos, (2.0 + x.x) * sin, x.z);
        }
        let found = gradients_of_potential(&mesh.tets, &mesh.vertices, [&zero, &one]);
        let found = found.expect("a ring is connected");
        for (tet, gradient) in mesh.tets.iter().zip(&found) {
            let centre = tet.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 4.0;
            let radius = centre.xy().norm();
            let expected = Vec3::new(-centre.y, centre.x, 0.0) / (radius * radius);
            let error = gradient * 0.5 * std::f64::consts::PI - expected;
            assert!(error.norm() < 0.08 * expected.norm(), "{gradient} {expected}");
        }
    }

    #[test]
    fn elements_that_are_connected_with_no_surface_have_no_gradient() {
        let mesh = cube(1, 0.0);
        let found = gradients_of_potential(&mesh.tets, &mesh.vertices, [&[], &[]]);
        assert!(found.is_err() || found.is_ok_and(|g| g.iter().all(|g| *g == Vec3::zeros())));
    }
}
