//! A surface inside a body, at a depth below a part of its boundary, on which threads are laid.
//!
//! Each vertex has the distance d to the nearest point of the part. Between vertices d is linear in a tetrahedron, and
//! the layer is where d is the depth: a triangle or a quadrilateral in each tetrahedron, with corners on its edges.
//! Facets of neighbours share their corners, so that the layer has no gap. A vertex at the depth is a corner itself.
//!
//! Where distances are linear, below flat faces, the layer is exact. Below a curved one it is as good as the mesh: for
//! a circle of radius R, at most h²/8R off with edges of the length h. Where faces meet in an edge, an element may have
//! all corners on them: to linear distances it is no deeper than they are, and the layer passes it by.

use std::collections::HashMap;

use mesh::bvh::SurfaceBvh;
use mesh::{SurfaceMesh, Vec3};

use super::lay::Piece;

/// A distance from the depth that is rounding, relative to the depth [1].
const ROUNDING: f64 = 1e-9;

/// How much deeper than the layer the middle of an element that it passes by may be, over its longest edge [1]: below
/// curved faces less than h/8R. A corner of a cube with edges of elements has a tenth.
const PASSED: f64 = 0.03;

/// The points of a body at a depth below a part of its boundary.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Its triangles, as indices of `points`.
    pub facets: Vec<[usize; 3]>,
    /// Its corners at rest [m].
    pub points: Vec<Vec3>,
    /// The largest distance of a vertex from the part [m].
    pub deepest: f64,
    /// The middle of the element that the layer passes by although that is deepest below the part, and how deep [m]; none
    /// where no element is passed by that is deeper than the depth by more than `PASSED` of its longest edge.
    pub missed: Option<(Vec3, f64)>,
    /// The edge of the mesh that a corner is on, and how far from its first end [1].
    edges: Vec<([usize; 2], f64)>,
    /// The tetrahedron of each triangle.
    tets: HashMap<[usize; 3], [usize; 4]>,
}

impl Layer {
    /// The layer of a mesh at a depth [m] below some of its facets, at rest positions of its vertices.
    pub fn below(facets: &[[usize; 3]], tets: &[[usize; 4]], x: &[Vec3], depth: f64) -> Self {
        let part = SurfaceMesh { vertices: x.to_vec(), triangles: facets.to_vec() };
        let bvh = SurfaceBvh::new(&part);
        let deeper: Vec<f64> = x.iter().map(|x| bvh.closest(x).distance - depth).collect();
        let deepest = deeper.iter().fold(-depth, |most: f64, by| most.max(*by)) + depth;
        let mut layer = Self {
            facets: Vec::new(),
            points: Vec::new(),
            deepest,
            missed: None,
            edges: Vec::new(),
            tets: HashMap::new(),
        };
        let mut known = HashMap::new();
        for tet in tets {
            let by = tet.map(|v| if deeper[v].abs() < ROUNDING * depth { 0.0 } else { deeper[v] });
            let [above, below]: [Vec<usize>; 2] =
                [true, false].map(|is| (0..4).filter(|&k| (by[k] < 0.0) == is).collect());
            // around the quadrilateral of two corners above and two below
            let pairs: Vec<[usize; 2]> = match (&above[..], &below[..]) {
                ([a], [b, c, d]) | ([b, c, d], [a]) => {
                    [[a, b], [a, c], [a, d]].map(|[a, b]| [*a, *b]).to_vec()
                }
                ([a, b], [c, d]) => {
                    [[a, c], [a, d], [b, d], [b, c]].map(|[a, b]| [*a, *b]).to_vec()
                }
                ([_, _, _, _], []) => {
                    layer.pass(tet.map(|v| x[v]), &bvh, depth);
                    continue;
                }
                _ => continue,
            };
            let corners: Vec<usize> = pairs
                .into_iter()
                .map(|[a, b]| layer.corner([tet[a], tet[b]], [by[a], by[b]], x, &mut known))
                .collect();
            for k in 1..corners.len() - 1 {
                layer.add([corners[0], corners[k], corners[k + 1]], *tet);
            }
        }
        layer
    }

    /// Notes an element with all corners above the layer.
    fn pass(&mut self, corners: [Vec3; 4], bvh: &SurfaceBvh, depth: f64) {
        let middle = corners.iter().sum::<Vec3>() / 4.0;
        let deep = bvh.closest(&middle).distance;
        let pairs = (0..4).flat_map(|i| (0..i).map(move |j| [i, j]));
        let longest = pairs.map(|[i, j]| (corners[i] - corners[j]).norm()).fold(0.0, f64::max);
        if deep - depth > PASSED * longest && self.missed.is_none_or(|(_, most)| deep > most) {
            self.missed = Some((middle, deep));
        }
    }

    /// The corner on an edge between a vertex above and one below, with `by` how much deeper both are.
    fn corner(
        &mut self,
        [a, b]: [usize; 2],
        by: [f64; 2],
        x: &[Vec3],
        known: &mut HashMap<[usize; 2], usize>,
    ) -> usize {
        let ([low, high], [first, second]) =
            if a < b { ([a, b], by) } else { ([b, a], [by[1], by[0]]) };
        let part = first / (first - second);
        let key = match part {
            0.0 => [low, low],
            1.0 => [high, high],
            _ => [low, high],
        };
        *known.entry(key).or_insert_with(|| {
            self.points.push((1.0 - part) * x[low] + part * x[high]);
            self.edges.push(([low, high], part));
            self.points.len() - 1
        })
    }

    /// Adds a triangle in a tetrahedron, unless two of its corners are one.
    fn add(&mut self, [a, b, c]: [usize; 3], tet: [usize; 4]) {
        if a != b && b != c && c != a {
            self.facets.push([a, b, c]);
            self.tets.insert([a, b, c], tet);
        }
    }

    /// A piece in one of its triangles as a piece in the tetrahedron there.
    ///
    /// # Panics
    /// When the piece is in none of its triangles.
    pub fn inside(&self, piece: &Piece<3>) -> Piece<4> {
        let tet = self.tets[&piece.simplex];
        // barycentric coordinates of the corners are a linear map of those in the triangle
        let spread = |part: [f64; 3]| {
            let mut out = [0.0; 4];
            for (corner, part) in piece.simplex.into_iter().zip(part) {
                let ([low, high], along) = self.edges[corner];
                for (out, v) in out.iter_mut().zip(tet) {
                    *out += part
                        * if v == low {
                            1.0 - along
                        } else if v == high {
                            along
                        } else {
                            0.0
                        };
                }
            }
            out
        };
        Piece {
            simplex: tet,
            ends: piece.ends.map(spread),
            range: piece.range,
            rates: piece.rates.iter().map(|rates| rates.map(spread)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::polyline;
    use crate::testing::cube;
    use mesh::topology::boundary;

    /// The facets of a cube whose corners are all somewhere.
    fn facets_where(mesh: &mesh::TetMesh, is: impl Fn(&Vec3) -> bool) -> Vec<[usize; 3]> {
        let all = boundary(mesh).facets.into_iter();
        all.filter(|f| f.iter().all(|&v| is(&mesh.vertices[v]))).collect()
    }

    fn area(layer: &Layer) -> f64 {
        let one = |f: &[usize; 3]| {
            let [a, b, c] = f.map(|v| layer.points[v]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        layer.facets.iter().map(one).sum()
    }

    /// Between the vertices, and where all of them are at the depth.
    #[test]
    fn below_a_flat_face_it_is_flat() {
        for (jitter, depth) in [(0.2, 0.3), (0.2, 0.55), (0.0, 0.25), (0.0, 0.5), (0.0, 0.6)] {
            let mesh = cube(4, jitter);
            let top = facets_where(&mesh, |x| x.z > 1.0 - 1e-9);
            let layer = Layer::below(&top, &mesh.tets, &mesh.vertices, depth);
            assert!(layer.points.iter().all(|x| (x.z - 1.0 + depth).abs() < 1e-12));
            assert!((area(&layer) - 1.0).abs() < 1e-12, "{depth}: {}", area(&layer));
            assert!((layer.deepest - 1.0).abs() < 1e-12);
            assert!(Layer::below(&top, &mesh.tets, &mesh.vertices, 1.01).facets.is_empty());
        }
    }

    /// Below four side faces, the layer of a vertex at the depth on the edge has a sharp edge, too.
    #[test]
    fn below_faces_that_meet_it_has_their_edge() {
        let mesh = cube(4, 0.0);
        let side = |x: &Vec3| x.xy().iter().any(|x| *x < 1e-9 || *x > 1.0 - 1e-9);
        let mut sides = facets_where(&mesh, side);
        sides.retain(|f| f.iter().any(|&v| mesh.vertices[v].z != mesh.vertices[f[0]].z));
        let layer = Layer::below(&sides, &mesh.tets, &mesh.vertices, 0.25);
        assert!((area(&layer) - 2.0).abs() < 1e-12, "{}", area(&layer));
    }

    /// Pieces have their ends where the triangles have them.
    #[test]
    fn pieces_are_where_their_triangles_are() {
        let mesh = cube(3, 0.2);
        let top = facets_where(&mesh, |x| x.z > 1.0 - 1e-9);
        let layer = Layer::below(&top, &mesh.tets, &mesh.vertices, 0.4);
        let path = [[0.1, 0.2, 0.6], [0.8, 0.35, 0.6], [0.4, 0.9, 0.6]].map(Vec3::from);
        let pieces = polyline(&layer.facets, &layer.points, &path).expect("it lies in the layer");
        for piece in pieces {
            let inside = layer.inside(&piece);
            for end in [0, 1] {
                let apart = piece.place(&layer.points, end) - inside.place(&mesh.vertices, end);
                assert!(apart.norm() < 1e-14, "{apart}");
            }
        }
    }
}
