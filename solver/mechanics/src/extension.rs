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
//!
//! Where planes of symmetry cut the body, vertices inside a cut are interior: along the plane
//! they follow as those of the whole body would, of which K has the half; across it they stay.

use std::collections::BTreeMap;

use crate::body::Body;
use crate::math::linear::{
    Factorization, NotPositive, Precision, SparseSolver, Symmetric, one_by_one,
};
use crate::math::ordering::nested_dissection;
use crate::symmetry::{self, Plane};
use mesh::{TetMesh, Vec3};

/// Linear map from boundary to interior displacements.
pub struct Extension {
    /// Which of the systems belongs to each component.
    of_component: [usize; 3],
    /// One for all components, but where planes of symmetry hold some of them.
    systems: Vec<System>,
    planes: Vec<Plane>,
}

/// The equations of a component.
struct System {
    /// Interior vertex of each unknown, ascending.
    interior: Vec<usize>,
    /// K_ib by unknown: boundary vertices with their entries.
    coupling: Vec<Vec<(usize, f64)>>,
    /// The factor of K_ii.
    factored: Factorization,
}

impl Extension {
    /// The map of a body at its present vertex positions.
    pub fn new(body: &Body) -> Result<Self, NotPositive> {
        let mut inside = vec![false; body.mesh.vertices.len()];
        body.mesh.tets.iter().flatten().for_each(|&v| inside[v] = true);
        body.boundary().iter().flatten().for_each(|&v| inside[v] = false);
        let (mut systems, mut of_component, mut held) = (Vec::new(), [0; 3], Vec::new());
        for (axis, system) in of_component.iter_mut().enumerate() {
            let plane = body.planes.iter().find(|plane| plane.axis == axis);
            *system = held.iter().position(|other| *other == plane).unwrap_or(held.len());
            if *system == held.len() {
                let mut inside = inside.clone();
                let cut = plane.map_or(&[][..], Plane::vertices);
                cut.iter().for_each(|&v| inside[v] = false);
                systems.push(System::new(&body.mesh, &inside)?);
                held.push(plane);
            }
        }
        Ok(Self { of_component, systems, planes: body.planes.clone() })
    }

    /// Fills in the interior of `displacement`, a list over all vertices whose
    /// boundary entries are given; none of them leaves a plane of symmetry.
    pub fn apply(&self, displacement: &mut [Vec3]) {
        for (k, &system) in self.of_component.iter().enumerate() {
            self.systems[system].apply(k, displacement);
        }
    }

    /// The transpose: moves the cotangents of the interior entries of `bar`, a
    /// list over all vertices, to the boundary entries and clears them, and those across
    /// planes of symmetry.
    pub fn vjp(&self, bar: &mut [Vec3]) {
        for (k, &system) in self.of_component.iter().enumerate() {
            self.systems[system].vjp(k, bar);
        }
        symmetry::project(&self.planes, bar);
    }
}

impl System {
    fn new(mesh: &TetMesh, inside: &[bool]) -> Result<Self, NotPositive> {
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
        let order = one_by_one(&nested_dissection(&adjacency));
        let solver = SparseSolver::new(start, &entries, &order);
        let factored = solver.positive(Symmetric::sparse(values), Precision::Double)?;
        Ok(Self { interior, coupling, factored })
    }

    /// Fills in component `k` of the unknowns.
    fn apply(&self, k: usize, displacement: &mut [Vec3]) {
        let pull = |row: &Vec<(usize, f64)>| -> f64 {
            -row.iter().map(|&(w, c)| c * displacement[w][k]).sum::<f64>()
        };
        let solution = self.solve(self.coupling.iter().map(pull).collect());
        self.interior.iter().zip(solution).for_each(|(&v, d)| displacement[v][k] = d);
    }

    /// The transpose of the same.
    fn vjp(&self, k: usize, bar: &mut [Vec3]) {
        let pulls = self.solve(self.interior.iter().map(|&v| bar[v][k]).collect());
        self.interior.iter().for_each(|&v| bar[v][k] = 0.0);
        for (row, pull) in self.coupling.iter().zip(pulls) {
            row.iter().for_each(|&(w, c)| bar[w][k] -= c * pull);
        }
    }

    /// K_ii⁻¹ b.
    fn solve(&self, mut b: Vec<f64>) -> Vec<f64> {
        if !b.is_empty() {
            self.factored.solve(&mut b);
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
    use crate::math::random::Random;
    use crate::testing::cube;
    use mesh::Tags;

    use super::*;

    fn body(mesh: &TetMesh) -> Body {
        Body::new(mesh.clone(), Tags::default())
    }

    #[test]
    fn translations_are_exact_and_a_strong_squeeze_inverts_nothing() {
        let mesh = cube(5, 0.2);
        let extension = Extension::new(&body(&mesh)).unwrap();
        let interior = &extension.systems[0].interior;
        assert_eq!((extension.systems.len(), interior.len()), (1, 4 * 4 * 4));
        let extend = |motion: &dyn Fn(&Vec3) -> Vec3| {
            let mut displacement: Vec<Vec3> = mesh.vertices.iter().map(motion).collect();
            interior.iter().for_each(|&v| displacement[v] = Vec3::repeat(9.0));
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
    fn the_vjp_is_the_transpose() {
        let mesh = cube(5, 0.2);
        let extension = Extension::new(&body(&mesh)).unwrap();
        let interior = &extension.systems[0].interior;
        let mut random = Random::new(41);
        let mut draw = || -> Vec<Vec3> { mesh.vertices.iter().map(|_| random.vector()).collect() };
        let (mut data, bar) = (draw(), draw());
        interior.iter().for_each(|&v| data[v] = Vec3::zeros());
        let inner =
            |a: &[Vec3], b: &[Vec3]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(b)).sum() };

        let (mut extended, mut pulled) = (data.clone(), bar.clone());
        extension.apply(&mut extended);
        extension.vjp(&mut pulled);
        let (left, right) = (inner(&extended, &bar), inner(&data, &pulled));
        assert!((left - right).abs() < 1e-12 * left.abs().max(1.0), "{left} {right}");
        assert!(interior.iter().all(|&v| pulled[v] == Vec3::zeros()));
    }

    #[test]
    fn a_mesh_without_interior_vertices_is_left_alone() {
        let mesh = cube(1, 0.0);
        let extension = Extension::new(&body(&mesh)).unwrap();
        let mut displacement = mesh.vertices.clone();
        extension.apply(&mut displacement);
        assert_eq!(displacement, mesh.vertices);
    }
}
