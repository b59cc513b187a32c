//! Proof that a surface does not intersect itself.
//!
//! Decided by the exact signs of determinants (see [`mesh::predicates`]), with
//! nothing of what keeps steps free of contact: a mistake there shows here.

use mesh::predicates::{orient3d, segment_intersects_triangle};
use mesh::{SurfaceMesh, Vec3, crossings};

/// Two triangles that have more in common than their common vertices and edge.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "triangles {} and {} of the collision surface intersect at ({:.5}, {:.5}, {:.5}) m",
    triangles[0], triangles[1], place.x, place.y, place.z
)]
pub struct Intersection {
    /// The first pair, by indices.
    pub triangles: [usize; 2],
    /// A point that they have in common, up to rounding [m].
    pub place: Vec3,
}

/// That the surface of `triangles` at finite vertex positions `x` [m], open or
/// closed, nowhere touches or runs through itself. Vertices are shared by index.
/// Pairs of triangles none of whose corners is `movable` are skipped.
pub fn certify(
    triangles: &[[usize; 3]],
    x: &[Vec3],
    movable: impl Fn(usize) -> bool,
) -> Result<(), Intersection> {
    let Some(&(i, j)) = crossing_pairs(triangles, x, movable).first() else { return Ok(()) };
    let surface = SurfaceMesh { vertices: x.to_vec(), triangles: triangles.to_vec() };
    Err(Intersection { triangles: [i, j], place: place(&surface, i, j) })
}

/// All pairs of triangles that [`certify`] refuses.
pub fn crossing_pairs(
    triangles: &[[usize; 3]],
    x: &[Vec3],
    movable: impl Fn(usize) -> bool,
) -> Vec<(usize, usize)> {
    let surface = SurfaceMesh { vertices: x.to_vec(), triangles: triangles.to_vec() };
    let moves = |t: usize| triangles[t].iter().any(|&v| movable(v));
    let found = crossings::self_intersecting_pairs(&surface).into_iter();
    found.filter(|&(i, j)| moves(i) || moves(j)).collect()
}

/// Where an edge of one of two triangles meets the other.
fn place(surface: &SurfaceMesh, i: usize, j: usize) -> Vec3 {
    let crossing = |s: usize, t: usize| {
        let (edges, other) = (surface.triangles[s], surface.triangles[t]);
        let shared = |v: &usize| other.contains(v);
        let corners = surface.corners(t);
        (0..3).map(|k| [edges[k], edges[(k + 1) % 3]]).find_map(|edge| {
            let [p, q] = edge.map(|v| surface.vertices[v]);
            // an edge through a common vertex meets the other triangle there
            let meets = !edge.iter().any(shared) && segment_intersects_triangle(&p, &q, &corners);
            meets.then(|| meeting(&p, &q, &corners))
        })
    };
    crossing(i, j).or_else(|| crossing(j, i)).unwrap_or_else(|| {
        // folded onto each other about a common edge
        (surface.centroid(i) + surface.centroid(j)) / 2.0
    })
}

/// A point of the segment pq on the triangle that it meets.
fn meeting(p: &Vec3, q: &Vec3, [a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (from, to) = (orient3d(a, b, c, p), orient3d(a, b, c, q));
    if from == to { (p + q) / 2.0 } else { p + (q - p) * (from / (from - to)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of 2 n² triangles over [0, 1]², z = `height`(x, y).
    fn sheet(n: usize, height: impl Fn(f64, f64) -> f64) -> SurfaceMesh {
        let at = |i: usize, j: usize| i * (n + 1) + j;
        let step = |i: usize| i as f64 / n as f64;
        let point = |v: usize| {
            let (x, y) = (step(v / (n + 1)), step(v % (n + 1)));
            Vec3::new(x, y, height(x, y))
        };
        let squares = (0..n * n).map(|s| (s / n, s % n));
        let triangles = squares.flat_map(|(i, j)| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            [[a, b, c], [a, c, d]]
        });
        SurfaceMesh {
            triangles: triangles.collect(),
            vertices: (0..(n + 1) * (n + 1)).map(point).collect(),
        }
    }

    fn together(a: &SurfaceMesh, b: &SurfaceMesh) -> SurfaceMesh {
        let first = a.vertices.len();
        let shifted = b.triangles.iter().map(|t| t.map(|v| v + first));
        SurfaceMesh {
            triangles: a.triangles.iter().copied().chain(shifted).collect(),
            vertices: [&a.vertices[..], &b.vertices].concat(),
        }
    }

    fn check(surface: &SurfaceMesh) -> Result<(), Intersection> {
        certify(&surface.triangles, &surface.vertices, |_| true)
    }

    /// Through it, and in touch at one point.
    #[test]
    fn a_sheet_that_meets_another_is_found_at_a_place_on_both() {
        let floor = sheet(12, |_, _| 0.25);
        let dent = |depth: f64| {
            sheet(20, move |x, y| 0.25 + if (x, y) == (0.5, 0.5) { -depth } else { 0.125 })
        };
        assert_eq!(check(&together(&floor, &dent(-f64::EPSILON))), Ok(()));
        for depth in [0.0, f64::EPSILON, 1e-3, 0.5] {
            let found = check(&together(&floor, &dent(depth))).expect_err("in touch");
            let [i, j] = found.triangles;
            assert!(i < floor.triangles.len() && j >= floor.triangles.len(), "{found}");
            let away = found.place - Vec3::new(0.5, 0.5, 0.25);
            assert!(away.norm() < 0.05 && away.z.abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn what_cannot_move_may_be_in_touch() {
        let floor = sheet(4, |_, _| 0.0);
        let both = together(&floor, &sheet(3, |_, _| 0.0));
        let first = floor.vertices.len();
        assert!(check(&both).is_err());
        assert_eq!(certify(&both.triangles, &both.vertices, |_| false), Ok(()));
        assert!(certify(&both.triangles, &both.vertices, |v| v >= first).is_err());
    }
}
