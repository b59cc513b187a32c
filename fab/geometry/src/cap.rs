//! Closing a planar hole: a polygon cut into triangles.
//!
//! The polygon is projected to its plane (Newell's normal) and cut by a constrained Delaunay
//! triangulation (`spade`, with exact predicates). Vertices on one straight side, even if they
//! are off it by rounding, have a circumcircle that holds all others: they are no triangle.

use anyhow::{Context, Result, ensure};
use mesh::Vec3;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation, mitigate_underflow};

/// A triangulated polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Cap {
    /// Triangles of polygon indices, in the polygon's own direction.
    pub triangles: Vec<[usize; 3]>,
    /// Unit normal; the polygon is counter-clockwise around it [1].
    pub normal: Vec3,
    /// Largest distance of a vertex from the plane through the mean of all [m].
    pub deviation: f64,
}

/// Closes a polygon.
pub fn close(polygon: &[Vec3]) -> Result<Cap> {
    let vertices = polygon.len();
    let mean = polygon.iter().sum::<Vec3>() / vertices as f64;
    let area: Vec3 = (0..vertices)
        .map(|i| (polygon[i] - mean).cross(&(polygon[(i + 1) % vertices] - mean)))
        .sum();
    let reach = polygon.iter().map(|p| (p - mean).norm_squared()).fold(0.0, f64::max);
    ensure!(
        vertices >= 3 && area.norm() > 1e-9 * reach,
        "the rim of {vertices} vertices encloses no area"
    );
    let normal = area.normalize();
    let deviation = polygon.iter().map(|p| (p - mean).dot(&normal).abs()).fold(0.0, f64::max);
    let flat = flatten(polygon, &mean, &normal);
    let crosses =
        || format!("the rim of {vertices} vertices crosses itself when seen along its normal");
    let triangles = triangulate(&flat).with_context(crosses)?;
    Ok(Cap { triangles, normal, deviation })
}

/// The circle inscribed in a polygon: its centre [m] and radius [m].
///
/// The centre is searched on a grid over the bounding box that shrinks around
/// the best point; `normal` is that of the [`Cap`].
pub fn inscribed_circle(polygon: &[Vec3], normal: &Vec3) -> (Vec3, f64) {
    const SIDE: i32 = 8;
    const ROUNDS: usize = 12;
    let mean = polygon.iter().sum::<Vec3>() / polygon.len() as f64;
    let flat = flatten(polygon, &mean, normal);
    let mut best = ([0.0, 0.0], distance_inside(&flat, [0.0, 0.0]));
    let mut half = flat.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    for _ in 0..ROUNDS {
        let centre = best.0;
        for i in -SIDE..=SIDE {
            for j in -SIDE..=SIDE {
                let offset = |k: i32| f64::from(k) / f64::from(SIDE) * half;
                let p = [centre[0] + offset(i), centre[1] + offset(j)];
                let distance = distance_inside(&flat, p);
                if distance > best.1 {
                    best = (p, distance);
                }
            }
        }
        half /= 2.0;
    }
    let [u, v] = axes(normal);
    (mean + u * best.0[0] + v * best.0[1], best.1)
}

/// Two unit vectors with u × v = normal.
fn axes(normal: &Vec3) -> [Vec3; 2] {
    let mut seed = Vec3::zeros();
    seed[normal.iamin()] = 1.0;
    let u = (seed - normal * normal.dot(&seed)).normalize();
    [u, normal.cross(&u)]
}

fn flatten(polygon: &[Vec3], origin: &Vec3, normal: &Vec3) -> Vec<[f64; 2]> {
    let [u, v] = axes(normal);
    polygon.iter().map(|p| [(p - origin).dot(&u), (p - origin).dot(&v)]).collect()
}

/// Distance to the polygon, negative outside.
fn distance_inside(polygon: &[[f64; 2]], p: [f64; 2]) -> f64 {
    let mut inside = false;
    let mut nearest = f64::INFINITY;
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        if (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        {
            inside = !inside;
        }
        nearest = nearest.min(distance_to_segment(p, a, b));
    }
    if inside { nearest } else { -nearest }
}

fn distance_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (d, e) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = d[0] * d[0] + d[1] * d[1];
    let t = if length > 0.0 { ((d[0] * e[0] + d[1] * e[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    (e[0] - t * d[0]).hypot(e[1] - t * d[1])
}

/// Triangles of a counter-clockwise simple polygon; none if it is not simple.
fn triangulate(polygon: &[[f64; 2]]) -> Option<Vec<[usize; 3]>> {
    let mut plane = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let place = |&[x, y]: &[f64; 2]| mitigate_underflow(Point2::new(x, y));
    let corners: Result<Vec<_>, _> = polygon.iter().map(|p| plane.insert(place(p))).collect();
    let corners = corners.ok()?;
    let next = corners.iter().copied().cycle().skip(1);
    let mut sides = Vec::with_capacity(corners.len());
    for (from, to) in corners.iter().copied().zip(next) {
        // None where it would cross another side; several where it runs through a vertex.
        let [side] = plane.try_add_constraint(from, to)[..] else { return None };
        sides.push(side);
    }
    let mut inside = vec![false; plane.num_all_faces()];
    let mut open: Vec<_> = sides.iter().map(|&side| plane.directed_edge(side).face()).collect();
    while let Some(face) = open.pop() {
        let face = face.as_inner()?;
        if !std::mem::replace(&mut inside[face.index()], true) {
            let edges = face.adjacent_edges().into_iter();
            open.extend(edges.filter(|e| !e.is_constraint_edge()).map(|e| e.rev().face()));
        }
    }
    let filled = plane.inner_faces().filter(|face| inside[face.index()]);
    let triangles: Vec<_> = filled.map(|face| face.vertices().map(|v| v.index())).collect();
    // A polygon that touches itself has another count.
    (triangles.len() + 2 == polygon.len()).then_some(triangles)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::f64::consts::TAU;

    use mesh::SurfaceMesh;

    use super::*;

    fn lifted(points: &[[f64; 2]]) -> Vec<Vec3> {
        points.iter().map(|p| Vec3::new(p[0], 2.0, p[1])).collect()
    }

    fn area(polygon: &[Vec3], cap: &Cap) -> f64 {
        let signed = |&[a, b, c]: &[usize; 3]| {
            let (ab, ac) = (polygon[b] - polygon[a], polygon[c] - polygon[a]);
            ab.cross(&ac).dot(&cap.normal) / 2.0
        };
        cap.triangles.iter().map(signed).sum()
    }

    /// A star-shaped polygon whose sides have vertices between their ends, off them by rounding.
    fn star(random: &mut impl FnMut() -> f64) -> (Vec<[f64; 2]>, f64) {
        let corners = 4 + (random() * 8.0) as usize;
        let turn = |i: usize| (i as f64 + 0.8 * random()) * TAU / corners as f64;
        let angles: Vec<f64> = (0..corners).map(turn).collect();
        let at = |angle: f64| (0.05 * (0.4 + random())) * Vec3::new(angle.cos(), angle.sin(), 0.0);
        let ends: Vec<Vec3> = angles.into_iter().map(at).collect();
        let (mut points, mut area) = (Vec::new(), 0.0);
        for (i, a) in ends.iter().enumerate() {
            let b = &ends[(i + 1) % corners];
            area += a.cross(b).z / 2.0;
            let count = 1 + (random() * 30.0) as usize;
            let on = |k: usize| a + (b - a) * (k as f64 / count as f64);
            let shaken = |k: usize| {
                let noise = if k == 0 { 0.0 } else { 1e-17 * (random() - 0.5) };
                [on(k).x + noise, on(k).y - noise]
            };
            points.extend((0..count).map(shaken));
        }
        (points, area)
    }

    #[test]
    fn vertices_on_straight_sides_leave_no_triangle_without_area() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for case in 0..300 {
            let (points, wanted) = star(&mut random);
            let polygon = lifted(&points);
            let cap = close(&polygon).unwrap_or_else(|e| panic!("{case}: {e}"));
            assert_eq!(cap.triangles.len(), points.len() - 2, "{case}");
            assert!((area(&polygon, &cap) - wanted).abs() < 1e-12 * wanted, "{case}");
            let surface = SurfaceMesh { vertices: polygon, triangles: cap.triangles };
            assert_eq!(mesh::check::run(&surface, &["degenerate", "manifold"]), [], "{case}");
        }
    }

    #[test]
    fn the_inscribed_circle_of_a_rectangle_touches_its_long_sides() {
        let polygon = lifted(&[[0., 0.], [5., 0.], [5., 2.], [0., 2.]]);
        let (centre, radius) = inscribed_circle(&polygon, &close(&polygon).unwrap().normal);
        assert!((radius - 1.0).abs() < 1e-3);
        assert!((centre.z - 1.0).abs() < 1e-3);
    }

    #[test]
    fn what_is_no_polygon_is_refused() {
        let line = lifted(&[[0., 0.], [1., 0.], [2., 0.]]);
        let said = |polygon: &[Vec3]| close(polygon).unwrap_err().to_string();
        assert!(said(&line).contains("3 vertices encloses no area"));
        let bow = lifted(&[[0., 0.], [3., 2.], [3., 0.], [0., 1.]]);
        assert!(said(&bow).contains("4 vertices crosses itself"));
    }
}
