//! Inside or outside of a surface: the generalised winding number.
//!
//! w(p) = Σ Ω(p) / 4π, the sum of the signed solid angles of all triangles: an
//! integer for closed surfaces, and a smooth estimate for surfaces with holes
//! (Jacobson, Kavan, Sorkine-Hornung 2013).
//!
//! The sum is hierarchical and yet exact: seen from outside its bounding box, a
//! patch of triangles has the same solid angle as any other patch within the box
//! with the same boundary, here the fan over its boundary edges.

use crate::{SurfaceMesh, Vec3};
use std::f64::consts::TAU;

/// Triangles below which a patch is not divided further.
const LEAF_SIZE: usize = 8;

/// A surface prepared for winding numbers.
pub struct WindingNumber {
    nodes: Vec<Node>,
}

/// A patch of the surface; the first node is the root.
struct Node {
    min: Vec3,
    max: Vec3,
    /// Triangles with the same boundary as the patch.
    fan: Vec<[Vec3; 3]>,
    content: Content,
}

enum Content {
    Children([usize; 2]),
    Triangles(Vec<[Vec3; 3]>),
}

impl WindingNumber {
    /// Divides the surface into nested patches, O(n log n).
    pub fn new(surface: &SurfaceMesh) -> Self {
        let centroids: Vec<Vec3> =
            (0..surface.triangles.len()).map(|t| surface.centroid(t)).collect();
        let mut order: Vec<usize> = (0..surface.triangles.len()).collect();
        let mut nodes = Vec::new();
        if !order.is_empty() {
            divide(surface, &centroids, &mut order, &mut nodes);
        }
        Self { nodes }
    }

    /// The winding number about `p`: 1 inside a closed surface that faces
    /// outward, 0 outside; ill-defined on the surface itself.
    pub fn at(&self, p: &Vec3) -> f64 {
        let mut angle = 0.0;
        let mut stack: Vec<usize> = (0..self.nodes.len().min(1)).collect();
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n];
            let outside = (0..3).any(|k| p[k] < node.min[k] || p[k] > node.max[k]);
            match &node.content {
                _ if outside => angle += solid_angles(p, &node.fan),
                Content::Children(children) => stack.extend(children),
                Content::Triangles(triangles) => angle += solid_angles(p, triangles),
            }
        }
        angle / (2.0 * TAU)
    }

    /// Whether `p` is inside: winding number above ½.
    pub fn contains(&self, p: &Vec3) -> bool {
        self.at(p) > 0.5
    }
}

/// Appends the node of the triangles in `order` and all nodes below it; returns
/// its number.
fn divide(
    surface: &SurfaceMesh,
    centroids: &[Vec3],
    order: &mut [usize],
    nodes: &mut Vec<Node>,
) -> usize {
    let triangles: Vec<[usize; 3]> = order.iter().map(|&t| surface.triangles[t]).collect();
    let corners = triangles.iter().flatten().map(|&v| surface.vertices[v]);
    let infinite = Vec3::repeat(f64::INFINITY);
    let (min, max) =
        corners.fold((infinite, -infinite), |(min, max), x| (min.inf(&x), max.sup(&x)));
    let index = nodes.len();
    let fan =
        boundary_fan(&triangles).into_iter().map(|t| t.map(|v| surface.vertices[v])).collect();
    let own = order.iter().map(|&t| surface.corners(t));
    nodes.push(Node { min, max, fan, content: Content::Triangles(Vec::new()) });
    nodes[index].content = if order.len() <= LEAF_SIZE {
        Content::Triangles(own.collect())
    } else {
        let axis = (max - min).imax();
        let middle = order.len() / 2;
        let key = |&t: &usize| (centroids[t][axis], t);
        order.select_nth_unstable_by(middle, |a, b| {
            let ((x, i), (y, j)) = (key(a), key(b));
            x.total_cmp(&y).then(i.cmp(&j))
        });
        let (left, right) = order.split_at_mut(middle);
        let left = divide(surface, centroids, left, nodes);
        let right = divide(surface, centroids, right, nodes);
        Content::Children([left, right])
    };
    index
}

/// Triangles over one vertex whose boundary is that of the given ones.
fn boundary_fan(triangles: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let mut edges: Vec<([usize; 2], i32)> = triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .map(|(a, b)| ([a.min(b), a.max(b)], if a < b { 1 } else { -1 }))
        .collect();
    edges.sort_unstable_by_key(|(edge, _)| *edge);
    // How many more triangles run along an edge forward than backward.
    let same = edges.chunk_by(|(a, _), (b, _)| a == b);
    let flow: Vec<([usize; 2], i32)> = same
        .map(|run| (run[0].0, run.iter().map(|(_, sign)| sign).sum()))
        .filter(|(_, count)| *count != 0)
        .collect();
    let Some(&([apex, _], _)) = flow.first() else { return Vec::new() };
    let mut fan = Vec::new();
    for ([a, b], count) in flow {
        let triangle = if count > 0 { [apex, a, b] } else { [apex, b, a] };
        if a != apex && b != apex {
            fan.extend(std::iter::repeat_n(triangle, count.unsigned_abs() as usize));
        }
    }
    fan
}

fn solid_angles(p: &Vec3, triangles: &[[Vec3; 3]]) -> f64 {
    triangles.iter().map(|t| solid_angle(p, t)).sum()
}

/// Signed solid angle of a triangle seen from `p`, positive when seen from behind
/// (van Oosterom, Strackee 1983).
fn solid_angle(p: &Vec3, triangle: &[Vec3; 3]) -> f64 {
    let [a, b, c] = triangle.map(|x| x - p);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let triple = a.dot(&b.cross(&c));
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * triple.atan2(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Solid;

    /// A ball with a smaller ball cut out of it, off centre.
    fn shell() -> SurfaceMesh {
        let ball = Solid::sphere(&Vec3::zeros(), 0.03, 48);
        ball.difference(&Solid::sphere(&Vec3::new(0.01, 0.0, 0.0), 0.01, 32)).to_surface()
    }

    fn grid() -> impl Iterator<Item = Vec3> {
        let n = 12;
        (0..n * n * n).map(move |i| {
            let cell = Vec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
            cell.map(|x| (x + 0.37) * 0.08 / n as f64 - 0.04)
        })
    }

    #[test]
    fn the_hierarchy_sums_what_the_triangles_sum() {
        let mut surface = shell();
        let check = |surface: &SurfaceMesh| {
            let all: Vec<_> = (0..surface.triangles.len()).map(|t| surface.corners(t)).collect();
            let winding = WindingNumber::new(surface);
            for p in grid() {
                let direct = solid_angles(&p, &all) / (2.0 * TAU);
                // Rounding of some thousand angles: 5000 ε ~ 1e-12.
                assert!((winding.at(&p) - direct).abs() < 1e-12, "{p:?}: {direct}");
            }
        };
        check(&surface);
        // Open: every third triangle is missing. Then with triangles doubled.
        surface.triangles = surface.triangles.chunks(3).flat_map(|t| t[1..].to_vec()).collect();
        check(&surface);
        surface.triangles.extend_from_within(100..400);
        check(&surface);
    }

    #[test]
    fn cavities_are_outside() {
        let winding = WindingNumber::new(&shell());
        for p in grid() {
            let (r, s) = (p.norm(), (p - Vec3::new(0.01, 0.0, 0.0)).norm());
            // The polyhedra are inscribed: leave out the layer of their sagitta.
            if (0.0299..0.03).contains(&r) || (0.0098..0.01).contains(&s) {
                continue;
            }
            assert_eq!(winding.contains(&p), r < 0.03 && s > 0.01, "{p:?}");
        }
    }
}
