//! Edges, facets, neighbours, components and boundaries.
//!
//! Everything here is combinatorial: no coordinate is looked at. Results come
//! in an order that depends on the vertex ids only.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::{SurfaceMesh, TetMesh, Vec3, facet_key};

/// Facets of a tetrahedron of positive volume, each counter-clockwise seen
/// from outside; facet `i` is opposite to corner `i`.
pub const TET_FACETS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Edges of a tetrahedron as pairs of corners.
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The boundary of a tetrahedral mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Boundary {
    /// Vertex ids of the tetrahedral mesh, counter-clockwise from outside,
    /// smallest first; facets are sorted by their sorted ids.
    pub facets: Vec<[usize; 3]>,
    /// The tetrahedron behind each facet.
    pub tet_of: Vec<usize>,
}

impl Boundary {
    /// The boundary as a surface without unused vertices, and for each of its
    /// vertices the id in `mesh`.
    pub fn surface(&self, mesh: &TetMesh) -> (SurfaceMesh, Vec<usize>) {
        submesh(&mesh.vertices, &self.facets)
    }
}

/// The facets with exactly one incident tetrahedron, oriented out of the solid.
pub fn boundary(mesh: &TetMesh) -> Boundary {
    let facet = |t: usize, i: usize| TET_FACETS[i].map(|c| mesh.tets[t][c]);
    let mut sides: Vec<_> = (0..mesh.tets.len())
        .flat_map(|t| [0, 1, 2, 3].map(|i| (facet_key(facet(t, i)), t, i)))
        .collect();
    sides.par_sort_unstable();
    let single = sides.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    let (facets, tet_of) =
        single.map(|side| (smallest_first(facet(side[0].1, side[0].2)), side[0].1)).unzip();
    Boundary { facets, tet_of }
}

/// Rotates a triangle so that its smallest vertex id comes first.
fn smallest_first([a, b, c]: [usize; 3]) -> [usize; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// The surface made of `facets` without the vertices they do not use, and for
/// each of its vertices the index in `vertices`. Vertices keep their order.
pub fn submesh(vertices: &[Vec3], facets: &[[usize; 3]]) -> (SurfaceMesh, Vec<usize>) {
    let (triangles, used) = renumbered(facets, vertices.len());
    (SurfaceMesh { vertices: used.iter().map(|&v| vertices[v]).collect(), triangles }, used)
}

impl SurfaceMesh {
    /// Some of the triangles, with the vertices that they use.
    pub fn part(&self, triangles: &[usize]) -> Self {
        let chosen: Vec<_> = triangles.iter().map(|&t| self.triangles[t]).collect();
        submesh(&self.vertices, &chosen).0
    }
}

impl TetMesh {
    /// The mesh of other tetrahedra, with the vertices that they use.
    pub fn with_tets(&self, tets: &[[usize; 4]]) -> Self {
        let (tets, used) = renumbered(tets, self.vertices.len());
        Self { vertices: used.iter().map(|&v| self.vertices[v]).collect(), tets }
    }
}

/// Cells with the vertices that they use, of `count`, numbered in their order; and those, ascending.
fn renumbered<const N: usize>(cells: &[[usize; N]], count: usize) -> (Vec<[usize; N]>, Vec<usize>) {
    let mut used: Vec<usize> = cells.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut new_id = vec![usize::MAX; count];
    used.iter().enumerate().for_each(|(new, &old)| new_id[old] = new);
    (cells.iter().map(|cell| cell.map(|v| new_id[v])).collect(), used)
}

/// The three edges of a triangle in its direction.
pub fn directed_edges([a, b, c]: [usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Sorted edge → the triangles that have it, ascending.
pub fn edge_facets(triangles: &[[usize; 3]]) -> BTreeMap<[usize; 2], Vec<usize>> {
    let sides = edge_sides(triangles);
    let same_edge = sides.chunk_by(|a, b| a.edge == b.edge);
    same_edge.map(|same| (same[0].edge, same.iter().map(|side| side.triangle).collect())).collect()
}

/// A triangle at one of its edges.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct EdgeSide {
    /// Ends of the edge, ascending.
    edge: [usize; 2],
    triangle: usize,
    /// The corners of the triangle where the edge, in its direction, starts and ends.
    corners: [usize; 2],
}

impl EdgeSide {
    /// The corner at the lower and at the higher end of the edge.
    fn ascending_corners(self, triangles: &[[usize; 3]]) -> [usize; 2] {
        let [from, to] = self.corners;
        let swapped = triangles[self.triangle][from] != self.edge[0];
        if swapped { [to, from] } else { [from, to] }
    }
}

/// All edges of all triangles, sorted, so that triangles at an edge are neighbours.
fn edge_sides(triangles: &[[usize; 3]]) -> Vec<EdgeSide> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (triangle, t) in triangles.iter().enumerate() {
        for corners in [[0, 1], [1, 2], [2, 0]] {
            let [a, b] = corners.map(|c| t[c]);
            sides.push(EdgeSide { edge: [a.min(b), a.max(b)], triangle, corners });
        }
    }
    sides.par_sort_unstable();
    sides
}

/// Edges with exactly one triangle, in the direction of that triangle, sorted
/// by their sorted ids.
pub fn boundary_edges(triangles: &[[usize; 3]]) -> Vec<[usize; 2]> {
    let sides = edge_sides(triangles);
    let single = sides.chunk_by(|a, b| a.edge == b.edge).filter(|same| same.len() == 1);
    single.map(|side| side[0].corners.map(|c| triangles[side[0].triangle][c])).collect()
}

/// The rims of an open, consistently oriented surface: closed loops of vertices
/// along the boundary edges. Loops that touch at a vertex are separated there,
/// so no loop visits a vertex twice. Boundary edges that close no loop, which
/// exist only if neighbours disagree in orientation, are left out.
pub fn boundary_loops(triangles: &[[usize; 3]]) -> Vec<Vec<usize>> {
    let mut next = BTreeMap::<usize, Vec<usize>>::new();
    for [a, b] in boundary_edges(triangles) {
        next.entry(a).or_default().push(b);
    }
    let starts: Vec<usize> = next.keys().copied().collect();
    let mut loops = Vec::new();
    for start in starts {
        let mut path = vec![start];
        let mut place = BTreeMap::from([(start, 0)]);
        while let Some(to) = path.last().and_then(|v| next.get_mut(v)).and_then(Vec::pop) {
            if let Some(&i) = place.get(&to) {
                let closed = path.split_off(i);
                closed.iter().for_each(|v| _ = place.remove(v));
                loops.push(closed);
            }
            place.insert(to, path.len());
            path.push(to);
        }
    }
    loops
}

/// Edge-connected components: lists of ascending triangle indices, ordered by
/// their first triangle.
pub fn components(triangles: &[[usize; 3]]) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(triangles.len());
    for pair in edge_sides(triangles).windows(2).filter(|pair| pair[0].edge == pair[1].edge) {
        sets.join(pair[0].triangle, pair[1].triangle);
    }
    sets.groups()
}

/// Whether the triangles form an oriented manifold, with or without rims: no
/// repeated vertex in a triangle, at most two triangles at an edge and those in
/// opposite directions, one fan of triangles at every vertex.
pub fn is_manifold(triangles: &[[usize; 3]]) -> bool {
    let collapsed = triangles.iter().any(|&[a, b, c]| a == b || b == c || c == a);
    let mut directed: Vec<_> = triangles.iter().flat_map(|&t| directed_edges(t)).collect();
    directed.sort_unstable();
    let repeated = directed.windows(2).any(|pair| pair[0] == pair[1]);
    !collapsed && !repeated && pinched_vertices(triangles).is_empty()
}

/// Vertices whose triangles do not form a single fan, ascending: two sheets
/// touch there in a point only.
pub fn pinched_vertices(triangles: &[[usize; 3]]) -> Vec<usize> {
    let mut corners = DisjointSets::new(3 * triangles.len());
    for pair in edge_sides(triangles).windows(2).filter(|pair| pair[0].edge == pair[1].edge) {
        let [a, b] = [pair[0], pair[1]]
            .map(|side| side.ascending_corners(triangles).map(|c| 3 * side.triangle + c));
        corners.join(a[0], b[0]);
        corners.join(a[1], b[1]);
    }
    let mut fans: Vec<[usize; 2]> = (0..3 * triangles.len())
        .map(|c| [triangles[c / 3][c % 3], corners.representative(c)])
        .collect();
    fans.sort_unstable();
    fans.dedup();
    let mut pinched: Vec<usize> =
        fans.windows(2).filter(|pair| pair[0][0] == pair[1][0]).map(|pair| pair[0][0]).collect();
    pinched.dedup();
    pinched
}

/// The edges of tetrahedra, each once, sorted.
pub fn tet_edges(tets: &[[usize; 4]]) -> Vec<[usize; 2]> {
    let mut edges: Vec<[usize; 2]> = tets
        .iter()
        .flat_map(|tet| TET_EDGES.map(|[i, j]| [tet[i].min(tet[j]), tet[i].max(tet[j])]))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// The other end of every edge at each of `n` vertices, in the order of `edges`.
pub fn vertex_neighbours(n: usize, edges: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); n];
    for &[a, b] in edges {
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    neighbours
}

/// Disjoint sets of 0..n; the representative of a set is its smallest member.
pub struct DisjointSets {
    parent: Vec<usize>,
}

impl DisjointSets {
    /// Sets of one member each.
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n).collect() }
    }

    /// The smallest member of the set of a member.
    pub fn representative(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    /// Makes one set of those of two members.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.representative(a), self.representative(b));
        self.parent[a.max(b)] = a.min(b);
    }

    /// The members of each set, ascending.
    pub fn groups(&mut self) -> Vec<Vec<usize>> {
        let mut groups = BTreeMap::<usize, Vec<usize>>::new();
        for i in 0..self.parent.len() {
            groups.entry(self.representative(i)).or_default().push(i);
        }
        groups.into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{enclosed_volume, volume};

    /// The unit cube as six tetrahedra around the diagonal from vertex 0 to 7 (Kuhn).
    fn cube() -> TetMesh {
        let bit = |v: usize, axis: usize| ((v >> axis) & 1) as f64;
        TetMesh {
            vertices: (0..8).map(|v| Vec3::new(bit(v, 0), bit(v, 1), bit(v, 2))).collect(),
            tets: vec![
                [0, 1, 3, 7],
                [0, 3, 2, 7],
                [0, 2, 6, 7],
                [0, 6, 4, 7],
                [0, 4, 5, 7],
                [0, 5, 1, 7],
            ],
        }
    }

    #[test]
    fn the_boundary_of_a_cube_is_closed_and_faces_outward() {
        let cube = cube();
        let boundary = boundary(&cube);
        let (surface, map) = boundary.surface(&cube);
        assert_eq!(boundary.facets.len(), 12);
        assert_eq!(map, (0..8).collect::<Vec<_>>());
        assert!(is_manifold(&surface.triangles));
        assert!(boundary_edges(&surface.triangles).is_empty());
        // Products of zeros and ones: no rounding.
        assert_eq!(enclosed_volume(&surface), volume(&cube));
        for (facet, &t) in boundary.facets.iter().zip(&boundary.tet_of) {
            assert!(facet.iter().all(|v| cube.tets[t].contains(v)));
            assert!(facet[0] < facet[1] && facet[0] < facet[2]);
        }
        // 12 edges of the cube, 6 face diagonals, 1 space diagonal.
        assert_eq!(tet_edges(&cube.tets).len(), 19);
    }

    #[test]
    fn rims_are_closed_loops_in_the_direction_of_their_triangles() {
        // An annulus: outer square 0..4, inner square 4..8, counter-clockwise.
        let mut ring = Vec::new();
        for i in 0..4 {
            let j = (i + 1) % 4;
            ring.push([i, j, 4 + j]);
            ring.push([i, 4 + j, 4 + i]);
        }
        let loops = boundary_loops(&ring);
        assert_eq!(loops, [vec![0, 1, 2, 3], vec![4, 7, 6, 5]]);
        assert!(is_manifold(&ring));
    }

    #[test]
    fn loops_that_touch_in_a_vertex_are_separated() {
        let bow_tie = [[0, 1, 2], [0, 3, 4]];
        let mut loops = boundary_loops(&bow_tie);
        loops.iter_mut().for_each(|l| l.sort_unstable());
        loops.sort_unstable();
        assert_eq!(loops, [[0, 1, 2], [0, 3, 4]]);
        assert_eq!(pinched_vertices(&bow_tie), [0]);
        assert!(!is_manifold(&bow_tie));
    }

    #[test]
    fn manifolds_need_two_opposite_triangles_at_an_edge() {
        assert!(is_manifold(&[[0, 1, 2], [1, 0, 3]]));
        assert!(!is_manifold(&[[0, 1, 2], [0, 1, 3]]));
        assert!(!is_manifold(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]));
        assert!(!is_manifold(&[[0, 1, 1]]));
    }
}
