//! Nodes and connectivity of a displacement field on a tetrahedral mesh.

use std::collections::{BTreeMap, BTreeSet};

use mesh::Vec3;

use super::Incidence;
use super::basis::{EDGES, FACES, HIGHEST_DEGREE, Tabulation, tabulate};
use super::quadrature;
use crate::math::tensor::{Mat3, cofactor};

/// Continuous displacements of degree 1, 2 or 3 on straight-sided tetrahedra.
///
/// The first nodes are the mesh vertices, in their order. Degree 2 adds one
/// node at the middle of every edge; degree 3 two at its thirds, from the lower
/// vertex id to the higher, and after all edges one at the centre of every
/// facet. Degree of freedom 3 i + k is component k of node i.
pub struct FunctionSpace {
    degree: usize,
    vertex_count: usize,
    tets: Vec<[usize; 4]>,
    /// First node of each edge, by ascending vertex ids.
    edge_node: BTreeMap<[usize; 2], usize>,
    /// Node of each facet, by ascending vertex ids.
    face_node: BTreeMap<[usize; 3], usize>,
    /// Rows of Π for the nodes after the vertices: vertices and their weights.
    added: Vec<[(usize, f64); 3]>,
    element_nodes: Vec<usize>,
    incidence: Incidence,
    volume: Tabulation,
    facet: Tabulation,
}

fn sorted<const N: usize>(mut vertices: [usize; N]) -> [usize; N] {
    vertices.sort_unstable();
    vertices
}

impl FunctionSpace {
    /// The space of a degree on tetrahedra with `vertex_count` vertices, with
    /// quadrature of [`quadrature::DEFAULT_DEGREE`].
    ///
    /// # Panics
    /// When `degree` is not 1, 2 or 3.
    pub fn new(degree: usize, vertex_count: usize, tets: Vec<[usize; 4]>) -> Self {
        Self::with_quadrature(degree, quadrature::DEFAULT_DEGREE, vertex_count, tets)
    }

    /// The space of a degree with volume quadrature exact to the degree `exact`. Facet
    /// quadrature is exact to at least 2p + 1, for which the volume behind a
    /// wall, of degree 3p − 2, is exact for p ≤ 3.
    ///
    /// # Panics
    /// When `degree` is not 1, 2 or 3.
    pub fn with_quadrature(
        degree: usize,
        exact: usize,
        vertex_count: usize,
        tets: Vec<[usize; 4]>,
    ) -> Self {
        assert!((1..=HIGHEST_DEGREE).contains(&degree), "degree {degree}: 1, 2 and 3 exist");
        let mut space = Self {
            degree,
            vertex_count,
            edge_node: BTreeMap::new(),
            face_node: BTreeMap::new(),
            added: Vec::new(),
            element_nodes: Vec::new(),
            incidence: Incidence::default(),
            volume: tabulate(degree, &quadrature::tetrahedron(exact)),
            facet: tabulate(degree, &quadrature::triangle(exact.max(2 * degree + 1))),
            tets,
        };
        space.number_nodes();
        space
    }

    fn number_nodes(&mut self) {
        let p = self.degree as f64;
        if self.degree > 1 {
            for [a, b] in mesh::topology::tet_edges(&self.tets) {
                self.edge_node.insert([a, b], self.node_count());
                let node = |k| [(a, (p - f64::from(k)) / p), (b, f64::from(k) / p), (b, 0.0)];
                self.added.extend((1..self.degree as i32).map(node));
            }
        }
        if self.degree == 3 {
            let faces = self.tets.iter().flat_map(|t| FACES.map(|f| sorted(f.map(|c| t[c]))));
            for face in faces.collect::<BTreeSet<_>>() {
                self.face_node.insert(face, self.node_count());
                self.added.push(face.map(|v| (v, 1.0 / 3.0)));
            }
        }
        for tet in self.tets.clone() {
            let nodes = self.simplex_nodes(&tet);
            self.element_nodes.extend(nodes);
        }
        self.incidence = Incidence::new(self.node_count(), &self.element_nodes);
    }

    /// Node ids of a facet or a tetrahedron in the order of its basis: its vertices, those of its edges (01, 12, 20
    /// of a facet), and those inside its facets.
    ///
    /// # Panics
    /// When it is none of the mesh, and the degree is above 1.
    pub fn simplex_nodes(&self, corners: &[usize]) -> Vec<usize> {
        let (edges, faces) =
            if corners.len() == 3 { (&EDGES[..3], &FACES[3..]) } else { (&EDGES[..], &FACES[..]) };
        let mut nodes = corners.to_vec();
        if self.degree > 1 {
            for &[a, b] in edges {
                nodes.extend(self.edge_nodes([corners[a], corners[b]]));
            }
        }
        if self.degree == 3 {
            nodes.extend(faces.iter().map(|f| self.face_node[&sorted(f.map(|c| corners[c]))]));
        }
        nodes
    }

    /// Polynomial degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of mesh vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.vertex_count + self.added.len()
    }

    /// Nodes of one element: 4, 10 or 20.
    pub fn nodes_per_element(&self) -> usize {
        let p = self.degree;
        (p + 1) * (p + 2) * (p + 3) / 6
    }

    /// The tetrahedra as vertex ids.
    pub fn tets(&self) -> &[[usize; 4]] {
        &self.tets
    }

    /// Node ids of all elements, one after the other.
    pub fn element_nodes(&self) -> &[usize] {
        &self.element_nodes
    }

    /// Where each node stands in [`Self::element_nodes`].
    pub fn incidence(&self) -> &Incidence {
        &self.incidence
    }

    /// Basis on the volume rule.
    pub fn volume_table(&self) -> &Tabulation {
        &self.volume
    }

    /// Basis on the facet rule.
    pub fn facet_table(&self) -> &Tabulation {
        &self.facet
    }

    /// Mass matrix ∫ φ_a φ_b of a tetrahedron with volume 1, row by row.
    pub fn reference_mass(&self) -> Vec<f64> {
        let table = tabulate(self.degree, &quadrature::tetrahedron(2 * self.degree));
        let n = self.nodes_per_element();
        let mut mass = vec![0.0; n * n];
        for (values, weight) in table.values.iter().zip(&table.weights) {
            for a in 0..n {
                for b in 0..n {
                    mass[n * a + b] += weight * values[a] * values[b];
                }
            }
        }
        mass
    }

    /// ∇u at the points of the volume rule of one element [1].
    pub(crate) fn displacement_gradients(
        &self,
        rest: &[Vec3],
        u: &[f64],
        element: usize,
    ) -> impl Iterator<Item = Mat3> {
        let [a, b, c, d] = self.tets[element].map(|v| rest[v]);
        let g = Mat3::from_columns(&[b - a, c - a, d - a]);
        let to_rest = cofactor(&g) / g.determinant();
        let n = self.nodes_per_element();
        let nodes = &self.element_nodes[element * n..(element + 1) * n];
        self.volume.gradients.iter().map(move |gradients| {
            let at_node = |(&node, gradient): (&usize, &[f64; 3])| {
                at(u, node) * (to_rest * Vec3::from(*gradient)).transpose()
            };
            nodes.iter().zip(gradients).map(at_node).sum()
        })
    }

    /// [`Self::simplex_nodes`] of a facet.
    pub fn facet_nodes(&self, facet: [usize; 3]) -> Vec<usize> {
        self.simplex_nodes(&facet)
    }

    /// Node ids inside an edge, from its first vertex to its second.
    ///
    /// # Panics
    /// When `edge` is no edge of the mesh and the degree is above 1.
    pub fn edge_nodes(&self, edge: [usize; 2]) -> Vec<usize> {
        if self.degree == 1 {
            return Vec::new();
        }
        let first = self.edge_node[&sorted(edge)];
        let mut nodes: Vec<usize> = (first..first + self.degree - 1).collect();
        if edge[0] > edge[1] {
            nodes.reverse();
        }
        nodes
    }

    /// The vertices that a node lies between; of a vertex itself.
    pub fn vertices_of_node(&self, node: usize) -> impl Iterator<Item = usize> + Clone {
        let row = match node.checked_sub(self.vertex_count) {
            None => [(node, 1.0), (node, 0.0), (node, 0.0)],
            Some(added) => self.added[added],
        };
        row.into_iter().filter(|(_, weight)| *weight != 0.0).map(|(vertex, _)| vertex)
    }

    /// Rest positions of all nodes, Π X [m].
    pub fn node_positions(&self, rest: &[Vec3]) -> Vec<Vec3> {
        (0..self.node_count()).map(|node| self.node_position(rest, node)).collect()
    }

    /// Rest position of one node [m].
    pub fn node_position(&self, rest: &[Vec3], node: usize) -> Vec3 {
        match node.checked_sub(self.vertex_count) {
            None => rest[node],
            Some(added) => self.added[added].iter().map(|&(v, w)| w * rest[v]).sum(),
        }
    }

    /// Adds Πᵀ of a nodal vector to a vertex vector.
    pub fn add_to_vertices(&self, nodal: &[f64], out: &mut [f64]) {
        for (o, n) in out.iter_mut().zip(nodal) {
            *o += n;
        }
        for (i, row) in self.added.iter().enumerate() {
            let value = at(nodal, self.vertex_count + i);
            for &(v, weight) in row {
                add_at(out, v, &(weight * value));
            }
        }
    }
}

/// The three components of node `i`.
pub fn at(field: &[f64], i: usize) -> Vec3 {
    Vec3::new(field[3 * i], field[3 * i + 1], field[3 * i + 2])
}

/// Adds a vector to the components of node `i`.
pub fn add_at(field: &mut [f64], i: usize, value: &Vec3) {
    for k in 0..3 {
        field[3 * i + k] += value[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::testing;

    /// A cube whose tetrahedra list their vertices in random even orders, so
    /// that edges are met in both directions.
    fn space(degree: usize) -> (FunctionSpace, Vec<Vec3>) {
        let mut mesh = testing::cube(2, 0.2);
        let mut random = Random::new(5);
        for tet in &mut mesh.tets {
            for _ in 0..5 {
                let k = if random.uniform() > 0.0 { 1 } else { 0 };
                tet[k..k + 3].rotate_left(1);
            }
        }
        (FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets), mesh.vertices)
    }

    #[test]
    fn every_element_finds_its_nodes_where_the_basis_has_them() {
        for degree in 1..=3 {
            let (space, rest) = space(degree);
            let positions = space.node_positions(&rest);
            assert_eq!(space.nodes_per_element(), super::super::basis::nodes(4, degree).len());
            let facets = mesh::topology::boundary(&mesh::TetMesh {
                vertices: rest.clone(),
                tets: space.tets().to_vec(),
            });
            let tets = space.tets().iter().map(|tet| tet.to_vec());
            for simplex in tets.chain(facets.facets.iter().map(|facet| facet.to_vec())) {
                let places = super::super::basis::nodes(simplex.len(), degree);
                for (node, index) in space.simplex_nodes(&simplex).iter().zip(places) {
                    let parts = index.iter().zip(&simplex);
                    let place: Vec3 =
                        parts.map(|(&i, &v)| i as f64 / degree as f64 * rest[v]).sum();
                    assert!((positions[*node] - place).norm() < 1e-14);
                }
            }
        }
    }
}
