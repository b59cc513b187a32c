//! Bounding-volume hierarchies: nearest point, ray hits, overlapping pairs.
//!
//! The tree is parry3d's, behind our types; this is the only file that names it.

use crate::{SurfaceMesh, Vec3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};
use rayon::prelude::*;

/// A surface that answers proximity queries in logarithmic time.
pub struct SurfaceBvh {
    tree: Bvh,
    corners: Vec<[Vec3; 3]>,
}

/// The point of a surface nearest to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The nearest point [m].
    pub point: Vec3,
    /// The triangle it lies on.
    pub triangle: usize,
    /// The distance from the query point [m].
    pub distance: f64,
}

impl SurfaceBvh {
    /// Builds the tree, O(n log n).
    pub fn new(surface: &SurfaceMesh) -> Self {
        let corners: Vec<_> = (0..surface.triangles.len()).map(|t| surface.corners(t)).collect();
        let boxes: Vec<_> = corners.iter().map(triangle_box).collect();
        Self { tree: tree(&boxes), corners }
    }

    /// The point of the surface nearest to `p`.
    ///
    /// # Panics
    /// If the surface has no triangle or `p` is not finite.
    pub fn closest(&self, p: &Vec3) -> Closest {
        let query = vector(p);
        let found = self.tree.find_best(
            f64::MAX,
            |node: &BvhNode, _| {
                let gap = (node.mins() - query).max(query - node.maxs());
                gap.max(Vector::ZERO).length()
            },
            |leaf, _| {
                let point = closest_on_triangle(p, &self.corners[leaf as usize]);
                Some(((point - p).norm(), point))
            },
        );
        let (leaf, (distance, point)) = found.expect("a surface with triangles, a finite point");
        Closest { point, triangle: leaf as usize, distance }
    }

    /// All hits of the ray `origin` + s `direction`, s ≥ 0, as (s, triangle) in
    /// ascending order.
    ///
    /// Neighbouring triangles decide about their common edge from the same
    /// numbers (Woop et al. 2013), so that no ray slips through a closed
    /// surface; one that passes exactly through an edge may hit both sides of
    /// it. Triangles seen edge-on are not hit.
    pub fn ray(&self, origin: &Vec3, direction: &Vec3) -> Vec<(f64, usize)> {
        let mut hits = Vec::new();
        self.tree.traverse(|node| {
            let (min, max) = (vec3(node.mins()), vec3(node.maxs()));
            if !line_meets_box(origin, direction, f64::INFINITY, &min, &max) {
                return TraversalAction::Prune;
            }
            if let Some(leaf) = node.leaf_data() {
                let triangle = leaf as usize;
                if let Some(s) = ray_meets_triangle(origin, direction, &self.corners[triangle]) {
                    hits.push((s, triangle));
                }
            }
            TraversalAction::Continue
        });
        hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        hits
    }

    /// The triangles whose bounding box meets the box [min, max], ascending.
    pub fn overlaps(&self, min: &Vec3, max: &Vec3) -> Vec<usize> {
        overlaps(&self.tree, &(*min, *max))
    }
}

/// All pairs (i, j) such that the boxes `a[i]` and `b[j]`, each (min, max) [m],
/// have a point in common; sorted.
pub fn overlapping_pairs(a: &[(Vec3, Vec3)], b: &[(Vec3, Vec3)]) -> Vec<(usize, usize)> {
    let tree = tree(b);
    a.par_iter()
        .enumerate()
        .flat_map_iter(|(i, query)| overlaps(&tree, query).into_iter().map(move |j| (i, j)))
        .collect()
}

/// Boxes that answer which of them a segment meets.
pub(crate) struct BoxTree {
    tree: Bvh,
}

impl BoxTree {
    /// Builds the tree of boxes (min, max) [m].
    pub(crate) fn new(boxes: &[(Vec3, Vec3)]) -> Self {
        Self { tree: tree(boxes) }
    }

    /// Calls `visit` for every box that the segment pq meets, and perhaps for some that it misses
    /// by rounding.
    pub(crate) fn each_met(&self, p: &Vec3, q: &Vec3, mut visit: impl FnMut(usize)) {
        let direction = q - p;
        self.tree.traverse(|node| {
            let (min, max) = (vec3(node.mins()), vec3(node.maxs()));
            if !line_meets_box(p, &direction, 1.0, &min, &max) {
                return TraversalAction::Prune;
            }
            if let Some(leaf) = node.leaf_data() {
                visit(leaf as usize);
            }
            TraversalAction::Continue
        });
    }
}

fn vector(p: &Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

fn vec3(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

fn tree(boxes: &[(Vec3, Vec3)]) -> Bvh {
    let leaves: Vec<_> =
        boxes.iter().map(|(min, max)| Aabb::new(vector(min), vector(max))).collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves)
}

fn overlaps(tree: &Bvh, (min, max): &(Vec3, Vec3)) -> Vec<usize> {
    let query = Aabb::new(vector(min), vector(max));
    let mut found: Vec<usize> = tree.intersect_aabb(&query).map(|leaf| leaf as usize).collect();
    found.sort_unstable();
    found
}

fn triangle_box([a, b, c]: &[Vec3; 3]) -> (Vec3, Vec3) {
    (a.inf(b).inf(c), a.sup(b).sup(c))
}

/// The point of a triangle nearest to `p`, by the Voronoi regions of its corners,
/// edges and face (Ericson, Real-Time Collision Detection, 2005, §5.1.5).
pub fn closest_on_triangle(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let (ap, bp, cp) = (p - a, p - b, p - c);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (d43, d56) = (d4 - d3, d5 - d6);
    if va <= 0.0 && d43 >= 0.0 && d56 >= 0.0 {
        return b + (c - b) * (d43 / (d43 + d56));
    }
    let total = va + vb + vc;
    a + ab * (vb / total) + ac * (vc / total)
}

/// Slab test for `origin` + s `direction`, 0 ≤ s ≤ `far`, widened by the rounding of the
/// quotients (Ize 2013).
fn line_meets_box(origin: &Vec3, direction: &Vec3, far: f64, min: &Vec3, max: &Vec3) -> bool {
    let (mut near, mut far) = (0.0_f64, far);
    for k in 0..3 {
        if direction[k] == 0.0 {
            if origin[k] < min[k] || origin[k] > max[k] {
                return false;
            }
            continue;
        }
        let s = (min[k] - origin[k]) / direction[k];
        let t = (max[k] - origin[k]) / direction[k];
        near = near.max(s.min(t));
        far = far.min(s.max(t));
    }
    near <= far * (1.0 + 4.0 * f64::EPSILON)
}

/// The parameter s ≥ 0 at which the ray meets the triangle.
///
/// The triangle is sheared so that the ray becomes the coordinate axis of its
/// largest component; the signs of three planar determinants then show on which
/// side of each edge the axis passes (Woop, Benthin, Wald 2013).
fn ray_meets_triangle(origin: &Vec3, direction: &Vec3, corners: &[Vec3; 3]) -> Option<f64> {
    let z = direction.iamax();
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let sheared = corners.map(|corner| {
        let r = corner - origin;
        let s = r[z] / direction[z];
        (r[x] - direction[x] * s, r[y] - direction[y] * s, s)
    });
    let side = |i: usize, j: usize| sheared[i].0 * sheared[j].1 - sheared[i].1 * sheared[j].0;
    let (u, v, w) = (side(1, 2), side(2, 0), side(0, 1));
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let total = u + v + w;
    if total == 0.0 {
        return None;
    }
    let s = (u * sheared[0].2 + v * sheared[1].2 + w * sheared[2].2) / total;
    (s >= 0.0).then_some(s)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::solid::Solid;

    /// Points that fill the cube [−r, r]³ evenly and never regularly.
    fn scattered(count: usize, r: f64) -> impl Iterator<Item = Vec3> {
        // Weyl sequence of square roots of primes.
        let step = Vec3::new(2.0_f64.sqrt(), 3.0_f64.sqrt(), 5.0_f64.sqrt());
        (1..=count).map(move |i| (step * i as f64).map(|x| (2.0 * x.fract() - 1.0) * r))
    }

    fn ball() -> SurfaceMesh {
        Solid::sphere(&Vec3::zeros(), 0.03, 32).to_surface()
    }

    #[test]
    fn closest_point_is_that_of_an_exhaustive_search() {
        let surface = ball();
        let tree = SurfaceBvh::new(&surface);
        for p in scattered(200, 0.05) {
            let found = tree.closest(&p);
            let distances = (0..surface.triangles.len())
                .map(|t| (closest_on_triangle(&p, &surface.corners(t)) - p).norm());
            let best = distances.fold(f64::INFINITY, f64::min);
            assert_eq!(found.distance, best);
            assert_eq!(found.distance, (found.point - p).norm());
            let on = closest_on_triangle(&found.point, &surface.corners(found.triangle));
            assert!((on - found.point).norm() < 1e-15);
        }
    }

    #[test]
    fn closest_point_on_each_region_of_a_triangle() {
        let t = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        for (query, expected) in [
            ([-1.0, -1.0, 1.0], [0.0, 0.0, 0.0]),
            ([2.0, -0.5, 0.0], [1.0, 0.0, 0.0]),
            ([-0.5, 2.0, 0.0], [0.0, 1.0, 0.0]),
            ([0.25, -1.0, 1.0], [0.25, 0.0, 0.0]),
            ([-1.0, 0.25, 1.0], [0.0, 0.25, 0.0]),
            ([1.0, 1.0, 1.0], [0.5, 0.5, 0.0]),
            ([0.25, 0.25, 3.0], [0.25, 0.25, 0.0]),
        ] {
            assert_eq!(closest_on_triangle(&query.into(), &t), Vec3::from(expected));
        }
    }

    #[test]
    fn rays_enter_and_leave_a_closed_surface_in_turn() {
        let surface = ball();
        let tree = SurfaceBvh::new(&surface);
        for (p, direction) in scattered(200, 0.015).zip(scattered(400, 1.0).skip(200)) {
            // From inside: one way out forward, one backward.
            let forward = tree.ray(&p, &direction);
            let backward = tree.ray(&p, &-direction);
            assert_eq!((forward.len(), backward.len()), (1, 1));
            let through = tree.ray(&(p - direction), &direction);
            assert_eq!(through.len(), 2);
            assert!(through[0].0 < through[1].0);
            let end = p + direction * forward[0].0;
            assert!(tree.closest(&end).distance < 1e-15);
        }
    }

    #[test]
    fn a_ray_through_vertices_and_edges_is_not_lost() {
        let surface = ball();
        let tree = SurfaceBvh::new(&surface);
        for v in &surface.vertices {
            assert!(!tree.ray(&Vec3::zeros(), v).is_empty());
        }
        for t in &surface.triangles {
            let middle = (surface.vertices[t[0]] + surface.vertices[t[1]]) / 2.0;
            assert!(!tree.ray(&Vec3::zeros(), &middle).is_empty());
        }
    }
}
