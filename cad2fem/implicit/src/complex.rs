//! Tetrahedra that meet in common faces and never overlap: the space in which a body is carved.
//!
//! Every coordinate is one that 32-bit floats hold, and every tetrahedron has a positive volume by an
//! exact predicate. The boundary of any set of them therefore is closed, oriented and does not cross
//! itself, in memory as in the file.

use std::collections::HashMap;

use mesh::Vec3;
use mesh::predicates::orient3d;
use mesh::topology::TET_EDGES;
use rayon::prelude::*;

/// An edge by its vertices, the lower first.
pub type Edge = [u32; 2];

/// Tetrahedra that fill a region, without overlap.
#[derive(Clone, Default)]
pub struct Complex {
    /// [m]
    pub vertices: Vec<Vec3>,
    /// Bit k of a vertex: it is on the surface of side k, or at the [`RIM`].
    pub on: Vec<u64>,
    /// Tetrahedra of positive volume.
    pub tets: Vec<[u32; 4]>,
}

/// The bit of vertices where the complex ends, but not the body.
pub const RIM: u64 = 1 << 63;

/// The faces of a tetrahedron, counter-clockwise from outside.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// The edge between two vertices.
pub fn edge(a: u32, b: u32) -> Edge {
    [a.min(b), a.max(b)]
}

/// Whether a tetrahedron has positive volume, exactly.
pub fn is_positive(vertices: &[Vec3], tet: [u32; 4]) -> bool {
    let [a, b, c, d] = tet.map(|v| &vertices[v as usize]);
    orient3d(a, b, c, d) > 0.0
}

impl Complex {
    /// The edges that `chosen` takes, sorted.
    pub fn edges(&self, chosen: impl Fn(u32, u32) -> bool) -> Vec<Edge> {
        let mut edges = Vec::new();
        for tet in &self.tets {
            for [i, j] in TET_EDGES {
                let [a, b] = edge(tet[i], tet[j]);
                if chosen(a, b) {
                    edges.push([a, b]);
                }
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The triangles between tetrahedra and nothing whose corners are all on one surface,
    /// counter-clockwise from outside. Others are where the complex ends inside the body.
    pub fn boundary(&self) -> Vec<[u32; 3]> {
        self.alone(|face| self.common(face) != 0)
    }

    /// Notes at which vertices the complex ends.
    pub fn mark_rim(&mut self) {
        for v in self.alone(|_| true).into_iter().flatten() {
            self.on[v as usize] |= RIM;
        }
    }

    /// Those chosen faces that one tetrahedron alone has, counter-clockwise from outside.
    fn alone(&self, chosen: impl Fn([u32; 3]) -> bool) -> Vec<[u32; 3]> {
        let mut faces = Vec::new();
        for tet in &self.tets {
            for face in FACES.map(|f| f.map(|k| tet[k])).into_iter().filter(|&f| chosen(f)) {
                let mut key = face;
                key.sort_unstable();
                faces.push((key, face));
            }
        }
        faces.par_sort_unstable();
        let alone = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
        alone.map(|same| same[0].1).collect()
    }

    /// The surfaces that all corners of a triangle are on, as bits.
    pub fn common(&self, face: [u32; 3]) -> u64 {
        face.iter().fold(!RIM, |bits, &v| bits & self.on[v as usize])
    }

    /// The vertices of [`Self::boundary`], except at the rim, whose triangles are not one closed fan: where
    /// sheets touch.
    pub fn pinched(&self, boundary: &[[u32; 3]]) -> Vec<u32> {
        let mut pinched = pinched(boundary);
        pinched.retain(|&v| self.on[v as usize] & RIM == 0);
        pinched
    }

    /// The tetrahedra with the marked edges split at the vertices `middle` of them, the edge with the
    /// lower vertex first, so that neighbours split their common face alike. What is left of a
    /// tetrahedron is taken from it by `taken`, with the tetrahedron.
    pub fn split(&self, middle: &HashMap<Edge, u32>, mut taken: impl FnMut([u32; 4], [u32; 4])) {
        let mut ends = vec![false; self.vertices.len()];
        middle.keys().flatten().for_each(|&v| ends[v as usize] = true);
        for &tet in &self.tets {
            if tet.iter().filter(|&&v| ends[v as usize]).count() < 2 {
                taken(tet, tet);
            } else {
                split(tet, middle, &mut |part| taken(tet, part));
            }
        }
    }

    /// The tetrahedra at each vertex.
    pub fn stars(&self) -> Stars {
        let mut start = vec![0; self.vertices.len() + 1];
        self.tets.iter().flatten().for_each(|&v| start[v as usize + 1] += 1);
        for v in 1..start.len() {
            start[v] += start[v - 1];
        }
        let (mut next, mut tets) = (start.clone(), vec![0; 4 * self.tets.len()]);
        for (t, tet) in self.tets.iter().enumerate() {
            for &v in tet {
                tets[next[v as usize]] = t;
                next[v as usize] += 1;
            }
        }
        Stars { start, tets }
    }

    /// Leaves out vertices of no tetrahedron.
    pub fn compact(&mut self) {
        let mut place = vec![u32::MAX; self.vertices.len()];
        self.tets.iter().flatten().for_each(|&v| place[v as usize] = 0);
        let used: Vec<usize> = (0..place.len()).filter(|&v| place[v] == 0).collect();
        for (new, &old) in used.iter().enumerate() {
            place[old] = new as u32;
        }
        self.vertices = used.iter().map(|&v| self.vertices[v]).collect();
        self.on = used.iter().map(|&v| self.on[v]).collect();
        self.tets.iter_mut().flatten().for_each(|v| *v = place[*v as usize]);
    }
}

/// The tetrahedra at each vertex, one after the other.
pub struct Stars {
    start: Vec<usize>,
    tets: Vec<usize>,
}

impl Stars {
    /// Those at a vertex.
    pub fn at(&self, v: u32) -> &[usize] {
        &self.tets[self.start[v as usize]..self.start[v as usize + 1]]
    }
}

/// Splits the marked edge with the lowest middle, then what comes of it.
fn split(tet: [u32; 4], middle: &HashMap<Edge, u32>, taken: &mut impl FnMut([u32; 4])) {
    let marked = |[i, j]: [usize; 2]| Some((*middle.get(&edge(tet[i], tet[j]))?, i, j));
    let Some((m, i, j)) = TET_EDGES.into_iter().filter_map(marked).min() else { return taken(tet) };
    for corner in [j, i] {
        let mut half = tet;
        half[corner] = m;
        split(half, middle, taken);
    }
}

/// The vertices of a surface whose triangles are not one closed fan: where sheets touch.
fn pinched(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut spokes: Vec<[u32; 3]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]).collect();
    spokes.sort_unstable();
    let fans = spokes.chunk_by(|s, t| s[0] == t[0]);
    fans.filter(|fan| !is_closed(fan)).map(|fan| fan[0][0]).collect()
}

/// Whether the opposite edges of a vertex's triangles, sorted by where they begin, are one loop.
fn is_closed(fan: &[[u32; 3]]) -> bool {
    let mut at = fan[0][1];
    for turn in 1..=fan.len() {
        let Ok(next) = fan.binary_search_by_key(&at, |spoke| spoke[1]) else { return false };
        at = fan[next][2];
        if at == fan[0][1] {
            return turn == fan.len();
        }
    }
    false
}
