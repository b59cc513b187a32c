//! Sparsity pattern, ordering and symbolic factorisation of a Hessian.
//!
//! The graph of the mesh vertices is ordered by nested dissection, not that of all nodes,
//! which at degree 2 has seven times as many: every other node is eliminated with the
//! first of the vertices that it lies between. A separator of the vertices is then one of
//! the nodes: a node whose vertices are not all in the separator is on the side of the
//! others, and so are all nodes that share an element with it.

use std::ops::Range;

use mesh::topology::{tet_edges, vertex_neighbours};

use super::dirichlet::Dirichlet;
use crate::element::FunctionSpace;
use crate::math::linear::{Memory, SparseSolver, Triangle};
use crate::math::ordering::nested_dissection;
use crate::math::sparse::{FreeTriangle, Pattern};

/// The sparsity pattern of the Hessian with the given couplings of nodes that share no
/// element, its part on the unknowns of the conditions, and the symbolic factorisation of
/// that.
pub(super) fn symbolic(
    space: &FunctionSpace,
    dirichlet: &Dirichlet,
    couplings: &[[usize; 2]],
    memory: Memory,
) -> (Pattern, FreeTriangle, SparseSolver) {
    let nodes = (space.node_count(), space.element_nodes(), space.nodes_per_element());
    let followers = dirichlet.followers();
    let mut couplings = couplings.to_vec();
    if !followers.is_empty() {
        // those of the masters that nodes follow
        couplings.extend(Pattern::new(nodes.0, nodes.1, nodes.2, &couplings).images(followers));
    }
    let (nodes, (pattern, (free, column_start, rows))) = rayon::join(
        || node_order(space, &couplings),
        || {
            let pattern = Pattern::new(nodes.0, nodes.1, nodes.2, &couplings);
            let free = FreeTriangle::new(&pattern, &dirichlet.eliminated());
            (pattern, free)
        },
    );
    let groups = groups_of_unknowns(&nodes, &free, space.node_count());
    let triangle = Triangle::new(column_start, &rows);
    let linear = SparseSolver::with(triangle, &groups, memory);
    (pattern, free, linear)
}

/// The nodes in an order of elimination with little fill.
fn node_order(space: &FunctionSpace, couplings: &[[usize; 2]]) -> Vec<usize> {
    let mut edges = tet_edges(space.tets());
    for &[a, b] in couplings {
        let [a, b] = [a, b].map(|node| space.vertices_of_node(node));
        edges.extend(a.flat_map(|v| b.clone().map(move |w| [v.min(w), v.max(w)])));
    }
    edges.retain(|[a, b]| a != b);
    edges.sort_unstable();
    edges.dedup();
    let adjacency = vertex_neighbours(space.vertex_count(), &edges);
    let mut position = vec![0; space.vertex_count()];
    for (i, vertex) in nested_dissection(&adjacency).into_iter().enumerate() {
        position[vertex] = i;
    }
    let mut order: Vec<usize> = (0..space.node_count()).collect();
    order.sort_by_cached_key(|&node| {
        let first = space.vertices_of_node(node).map(|v| position[v]).min();
        // the vertex itself, whose front is the largest, after the nodes beside it
        (first, node < space.vertex_count())
    });
    order
}

/// The unknowns of each node that has any, in the order of the nodes.
fn groups_of_unknowns(
    nodes: &[usize],
    free: &FreeTriangle,
    node_count: usize,
) -> Vec<Range<usize>> {
    let mut groups = vec![0..0; node_count];
    for (i, &dof) in free.dof.iter().enumerate() {
        let group = &mut groups[dof / 3];
        *group = if group.start == group.end { i..i + 1 } else { group.start..i + 1 };
    }
    let groups = nodes.iter().map(|&node| groups[node].clone());
    groups.filter(|group| group.start < group.end).collect()
}
