//! Exact geometric predicates.
//!
//! Every answer is decided by the sign of a determinant that is evaluated
//! exactly for the given floating-point coordinates (Shewchuk 1997, crate
//! `robust`), so no test here has a tolerance. Triangles and segments are closed
//! sets: touching is intersecting.

use crate::Vec3;
use robust::{Coord, Coord3D};

/// Six times the signed volume of the tetrahedron (a, b, c, d) [m³].
///
/// The sign is exact: positive when d lies on the side of the plane (a, b, c)
/// to which the normal (b − a) × (c − a) points, zero when the four points are
/// coplanar. The magnitude carries rounding.
pub fn orient3d(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> f64 {
    // On a common coordinate plane, where only the slow exact path would find the zero.
    if (0..3).any(|k| a[k] == b[k] && a[k] == c[k] && a[k] == d[k]) {
        return 0.0;
    }
    let coord = |p: &Vec3| Coord3D { x: p.x, y: p.y, z: p.z };
    -robust::orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// Twice the signed area of (a, b, c) seen along coordinate axis `axis` [m²],
/// exact sign.
fn orient2d(axis: usize, a: &Vec3, b: &Vec3, c: &Vec3) -> f64 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let coord = |p: &Vec3| Coord { x: p[u], y: p[v] };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// Whether all values are ≥ 0 or all are ≤ 0.
fn same_sign(values: &[f64]) -> bool {
    values.iter().all(|&x| x >= 0.0) || values.iter().all(|&x| x <= 0.0)
}

/// Whether the segment pq and the triangle have a point in common.
pub fn segment_intersects_triangle(p: &Vec3, q: &Vec3, triangle: &[Vec3; 3]) -> bool {
    let [a, b, c] = triangle;
    if boxes_apart(&[p, q], &[a, b, c]) {
        return false;
    }
    let (side_p, side_q) = (orient3d(a, b, c, p), orient3d(a, b, c, q));
    if (side_p > 0.0 && side_q > 0.0) || (side_p < 0.0 && side_q < 0.0) {
        return false;
    }
    // The volumes of pq with the three edges have one sign when the line pq
    // passes through the triangle.
    let around = [orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)];
    if !same_sign(&around) {
        return false;
    }
    let crosses_plane = side_p != 0.0 || side_q != 0.0;
    // All five points in one plane. Seen along the axis that is most normal to
    // it the picture is one-to-one; the other two views are necessary conditions.
    crosses_plane || (0..3).all(|axis| segment_meets_triangle_2d(axis, p, q, triangle))
}

/// Whether a coordinate plane separates two sets of points strictly.
fn boxes_apart(these: &[&Vec3], those: &[&Vec3]) -> bool {
    let range = |points: &[&Vec3], k: usize| {
        let values = points.iter().map(|p| p[k]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
    };
    (0..3).any(|k| {
        let (a, b) = (range(these, k), range(those, k));
        a.1 < b.0 || b.1 < a.0
    })
}

/// The planar version of [`segment_intersects_triangle`], seen along `axis`.
fn segment_meets_triangle_2d(axis: usize, p: &Vec3, q: &Vec3, triangle: &[Vec3; 3]) -> bool {
    let [a, b, c] = triangle;
    let edges = [(a, b), (b, c), (c, a)];
    let around = edges.map(|(s, t)| orient2d(axis, s, t, p));
    let contains_p = same_sign(&around) && around.iter().any(|&x| x != 0.0);
    contains_p || edges.iter().any(|(s, t)| segments_meet_2d(axis, p, q, s, t))
}

/// Whether the segments ab and cd have a point in common, seen along `axis`.
fn segments_meet_2d(axis: usize, a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> bool {
    let (abc, abd) = (orient2d(axis, a, b, c), orient2d(axis, a, b, d));
    let (cda, cdb) = (orient2d(axis, c, d, a), orient2d(axis, c, d, b));
    let straddles = |x: f64, y: f64| (x >= 0.0 && y <= 0.0) || (x <= 0.0 && y >= 0.0);
    if !straddles(abc, abd) || !straddles(cda, cdb) {
        return false;
    }
    // Collinear segments meet where their coordinate intervals do.
    [(axis + 1) % 3, (axis + 2) % 3]
        .iter()
        .all(|&k| a[k].min(b[k]) <= c[k].max(d[k]) && c[k].min(d[k]) <= a[k].max(b[k]))
}

/// Whether the triangles (u, v, a) and (u, v, b) meet anywhere but in uv: only
/// when they are folded onto each other, coplanar and on the same side of uv.
pub fn edge_sharing_intersect(u: &Vec3, v: &Vec3, a: &Vec3, b: &Vec3) -> bool {
    let same_side = |axis| {
        let (side_a, side_b) = (orient2d(axis, u, v, a), orient2d(axis, u, v, b));
        (side_a > 0.0 && side_b > 0.0) || (side_a < 0.0 && side_b < 0.0)
    };
    orient3d(u, v, a, b) == 0.0 && (0..3).any(same_side)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Whether two triangles have a point in common, coplanar ones included.
    ///
    /// Where two triangles meet, an edge of one of them meets the other: their
    /// common set is convex, and each of its extreme points lies on an edge.
    pub(crate) fn triangles_intersect(t0: &[Vec3; 3], t1: &[Vec3; 3]) -> bool {
        (0..3).any(|i| {
            segment_intersects_triangle(&t0[i], &t0[(i + 1) % 3], t1)
                || segment_intersects_triangle(&t1[i], &t1[(i + 1) % 3], t0)
        })
    }

    /// Whether the triangles (v, a, b) and (v, c, d) meet anywhere but in v.
    ///
    /// Their common set is star-shaped about v, so if it is more than v it reaches
    /// the edge opposite v of one of them.
    pub(crate) fn corner_sharing_intersect(v: &Vec3, ab: [&Vec3; 2], cd: [&Vec3; 2]) -> bool {
        segment_intersects_triangle(ab[0], ab[1], &[*v, *cd[0], *cd[1]])
            || segment_intersects_triangle(cd[0], cd[1], &[*v, *ab[0], *ab[1]])
    }

    fn p(x: f64, y: f64, z: f64) -> Vec3 {
        Vec3::new(x, y, z)
    }

    fn flat() -> [Vec3; 3] {
        [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0)]
    }

    #[test]
    fn orientation_is_exact_where_naive_arithmetic_is_not() {
        // Points on the plane z = x moved off it by one unit in the last place.
        let (a, b, c) = (p(0.1, 0.1, 0.1), p(0.7, 0.3, 0.7), p(0.3, 0.9, 0.3));
        let x: f64 = 1.3;
        assert!(orient3d(&a, &b, &c, &p(x, 12.0, x)) == 0.0);
        assert!(orient3d(&a, &b, &c, &p(x, 12.0, x.next_up())) > 0.0);
        assert!(orient3d(&a, &b, &c, &p(x, 12.0, x.next_down())) < 0.0);
        let [a, b, c] = flat();
        assert_eq!(orient3d(&a, &b, &c, &p(0.0, 0.0, 1.0)), 1.0);
    }

    #[test]
    fn piercing_touching_and_missing() {
        let at = |z: f64| [p(0.2, 0.2, z), p(0.3, 0.2, 1.0), p(0.2, 0.3, 1.0)];
        assert!(triangles_intersect(&flat(), &at(-1.0)));
        assert!(triangles_intersect(&flat(), &at(0.0)));
        assert!(!triangles_intersect(&flat(), &at(f64::MIN_POSITIVE)));
        let beside = at(-1.0).map(|q| q + p(0.0, 0.9, 0.0));
        assert!(!triangles_intersect(&flat(), &beside));
    }

    #[test]
    fn coplanar_triangles_in_any_plane() {
        // (x, y) ↦ three planes, one of them seen edge-on along two axes.
        let planes: [fn(f64, f64) -> Vec3; 3] =
            [|x, y| p(x, y, 0.25), |x, y| p(0.5, x, y), |x, y| p(x, y, x + y)];
        for plane in planes {
            let triangle = |x: f64, y: f64, s: f64| [plane(x, y), plane(x + s, y), plane(x, y + s)];
            let big = triangle(0.0, 0.0, 1.0);
            assert!(triangles_intersect(&big, &triangle(0.25, 0.25, 0.125)), "contained");
            assert!(triangles_intersect(&triangle(0.25, 0.25, 0.125), &big), "containing");
            assert!(triangles_intersect(&big, &triangle(-0.5, 0.25, 1.0)), "crossing");
            assert!(triangles_intersect(&big, &triangle(1.0, 0.0, 1.0)), "touching");
            assert!(!triangles_intersect(&big, &triangle(0.75, 0.5, 1.0)), "apart");
        }
    }

    #[test]
    fn degenerate_triangles_are_segments() {
        let needle = |z: f64| [p(0.1, 0.1, z), p(0.1, 0.1, z + 1.0), p(0.1, 0.1, z + 2.0)];
        assert!(triangles_intersect(&flat(), &needle(-1.5)));
        assert!(!triangles_intersect(&flat(), &needle(0.5)));
        let level = [p(0.0, 0.0, 0.0), p(0.5, 0.5, 0.0), p(1.0, 1.0, 0.0)];
        assert!(triangles_intersect(&level, &needle(-1.5)));
        assert!(!triangles_intersect(&level, &needle(0.5)));
        assert!(!triangles_intersect(&level, &needle(-1.5).map(|q| q + p(0.5, 0.0, 0.0))));
    }

    #[test]
    fn neighbours_meet_only_beyond_what_they_share() {
        let [v, a, b] = flat();
        let (c, d) = (p(-1.0, 0.0, 0.0), p(-1.0, -1.0, 0.0));
        assert!(!corner_sharing_intersect(&v, [&a, &b], [&c, &d]));
        assert!(!corner_sharing_intersect(&v, [&a, &b], [&p(0.0, 0.0, 1.0), &c]));
        assert!(corner_sharing_intersect(&v, [&a, &b], [&p(1.0, 1.0, 1.0), &p(1.0, 1.0, -1.0)]));
        assert!(corner_sharing_intersect(&v, [&a, &b], [&p(0.25, 0.25, 0.0), &p(9.0, 8.0, 0.0)]));
        assert!(edge_sharing_intersect(&v, &a, &b, &p(5.0, 0.1, 0.0)));
        assert!(!edge_sharing_intersect(&v, &a, &b, &p(5.0, 0.1, 1e-300)));
        assert!(!edge_sharing_intersect(&v, &a, &b, &p(5.0, -0.1, 0.0)));
    }
}
