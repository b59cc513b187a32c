//! Nodes and connectivity of a displacement field on a tetrahedral mesh.

use std::collections::BTreeMap;

use mesh::Vec3;

use super::basis::{EDGES, Tabulation, tabulate};
use super::quadrature;

/// Continuous P1 or P2 displacements on straight-sided tetrahedra.
///
/// The first nodes are the mesh vertices, in their order; a P2 space adds one
/// node at the middle of every edge. Degree of freedom 3 i + k is component k
/// of node i.
pub struct FunctionSpace {
    degree: usize,
    vertex_count: usize,
    tets: Vec<[usize; 4]>,
    edges: Vec<[usize; 2]>,
    edge_node: BTreeMap<[usize; 2], usize>,
    element_nodes: Vec<usize>,
    volume: Tabulation,
    facet: Tabulation,
}

fn sorted(edge: [usize; 2]) -> [usize; 2] {
    [edge[0].min(edge[1]), edge[0].max(edge[1])]
}

impl FunctionSpace {
    /// The space of a degree on tetrahedra with `vertex_count` vertices.
    ///
    /// # Panics
    /// When `degree` is neither 1 nor 2.
    #[must_use]
    pub fn new(degree: usize, vertex_count: usize, tets: Vec<[usize; 4]>) -> Self {
        assert!(degree == 1 || degree == 2, "degree {degree}: only 1 and 2 exist");
        let mut edges = Vec::new();
        if degree == 2 {
            edges = mesh::topology::tet_edges(&tets);
        }
        let edge_node: BTreeMap<_, _> =
            edges.iter().enumerate().map(|(i, &e)| (e, vertex_count + i)).collect();
        let mut element_nodes = Vec::new();
        for tet in &tets {
            element_nodes.extend(tet);
            if degree == 2 {
                element_nodes.extend(EDGES.map(|[a, b]| edge_node[&sorted([tet[a], tet[b]])]));
            }
        }
        Self {
            degree,
            vertex_count,
            tets,
            edges,
            edge_node,
            element_nodes,
            volume: tabulate(degree, &quadrature::tetrahedron()),
            facet: tabulate(degree, &quadrature::triangle()),
        }
    }

    /// Polynomial degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of mesh vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Number of nodes.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.vertex_count + self.edges.len()
    }

    /// Nodes of one element: 4 or 10.
    #[must_use]
    pub fn nodes_per_element(&self) -> usize {
        if self.degree == 1 { 4 } else { 10 }
    }

    /// The tetrahedra as vertex ids.
    #[must_use]
    pub fn tets(&self) -> &[[usize; 4]] {
        &self.tets
    }

    /// Node ids of all elements, one after the other.
    #[must_use]
    pub fn element_nodes(&self) -> &[usize] {
        &self.element_nodes
    }

    /// Basis on the volume rule.
    #[must_use]
    pub fn volume_table(&self) -> &Tabulation {
        &self.volume
    }

    /// Basis on the facet rule.
    #[must_use]
    pub fn facet_table(&self) -> &Tabulation {
        &self.facet
    }

    /// Node ids of a facet: its vertices, then its edges 01, 12, 20.
    ///
    /// # Panics
    /// When `facet` is no facet of the mesh.
    #[must_use]
    pub fn facet_nodes(&self, facet: [usize; 3]) -> Vec<usize> {
        let mut nodes = facet.to_vec();
        if self.degree == 2 {
            let edges = EDGES[..3].iter();
            nodes.extend(edges.map(|&[a, b]| self.edge_node[&sorted([facet[a], facet[b]])]));
        }
        nodes
    }

    /// Rest positions of all nodes, Π X [m].
    #[must_use]
    pub fn node_positions(&self, rest: &[Vec3]) -> Vec<Vec3> {
        let middles = self.edges.iter().map(|&[a, b]| 0.5 * (rest[a] + rest[b]));
        rest.iter().copied().chain(middles).collect()
    }

    /// Adds Πᵀ of a nodal vector to a vertex vector.
    pub fn add_to_vertices(&self, nodal: &[f64], out: &mut [f64]) {
        for (o, n) in out.iter_mut().zip(nodal) {
            *o += n;
        }
        for (i, edge) in self.edges.iter().enumerate() {
            let node = 3 * (self.vertex_count + i);
            for v in edge {
                for k in 0..3 {
                    out[3 * v + k] += 0.5 * nodal[node + k];
                }
            }
        }
    }
}

/// The three components of node `i`.
#[must_use]
pub fn at(field: &[f64], i: usize) -> Vec3 {
    Vec3::new(field[3 * i], field[3 * i + 1], field[3 * i + 2])
}

/// Adds a vector to the components of node `i`.
pub fn add_at(field: &mut [f64], i: usize, value: &Vec3) {
    for k in 0..3 {
        field[3 * i + k] += value[k];
    }
}
