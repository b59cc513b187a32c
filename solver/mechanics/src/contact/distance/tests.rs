use super::*;
use crate::math::random::Random;

const SCALES: [f64; 3] = [1.0, 1e-3, 1e3];

type Distance = fn(&[Vec3; 4]) -> Closest;

fn random_corners(random: &mut Random) -> [Vec3; 4] {
    std::array::from_fn(|_| random.vector())
}

/// Smallest distance over a grid of parameters of both features.
fn sampled(x: &[Vec3; 4], point: bool) -> f64 {
    let n = 60;
    let mut best = f64::INFINITY;
    for i in 0..=n {
        for j in 0..=n {
            let (s, t) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let r = if point {
                let (a, b) = (s * (1.0 - t), s * t);
                x[0] - x[1] - a * (x[2] - x[1]) - b * (x[3] - x[1])
            } else {
                x[0] + s * (x[1] - x[0]) - x[2] - t * (x[3] - x[2])
            };
            best = best.min(r.norm());
        }
    }
    best
}

#[test]
fn distances_agree_with_dense_sampling() {
    let mut random = Random::new(1);
    for (point, distance) in [(true, point_triangle as Distance), (false, edge_edge)] {
        for _ in 0..300 {
            let x = random_corners(&mut random);
            let (d, s) = (distance(&x).d2.sqrt(), sampled(&x, point));
            // edges are shorter than 2√3, so a sample lies within half a
            // grid diagonal, √2/2 · 3.5/60 = 0.041, of any point
            assert!(d <= s + 1e-12 && d > s - 0.042, "{d} against {s}");
        }
    }
}

fn check_gradient(x: &[Vec3; 4], distance: Distance, scale: f64) {
    let gradient = distance(x).d2_gradient();
    let h = 1e-6 * scale;
    for i in 0..4 {
        for k in 0..3 {
            let shifted = |s: f64| {
                let mut y = *x;
                y[i][k] += s;
                distance(&y).d2
            };
            let difference = (shifted(h) - shifted(-h)) / (2.0 * h);
            // curvature jumps across regions: error up to h · O(1)
            assert!((difference - gradient[i][k]).abs() < 1e-5 * scale);
        }
    }
}

/// Both derivatives of every region against differences, and the region's own closest points
/// against the clamped ones.
#[test]
fn every_region_has_the_derivatives_of_its_distance() {
    let mut random = Random::new(12);
    for scale in SCALES {
        for (first, count, distance) in [(1, 7, point_triangle as Distance), (2, 9, edge_edge)] {
            let mut seen = std::collections::BTreeSet::new();
            for _ in 0..600 {
                let x = random_corners(&mut random).map(|v| v * scale);
                let closest = distance(&x);
                let region = Region::of(first, &closest);
                let again = region.closest(&x);
                assert!((again.d2 - closest.d2).abs() < 1e-11 * scale * scale);
                seen.insert(region);
                check_gradient(&x, distance, scale);
                let direction = random_corners(&mut random).map(|v| v * scale);
                let gradient = |h: f64| {
                    let y = std::array::from_fn(|i| x[i] + h * direction[i]);
                    corners(region.closest(&y).d2_gradient())
                };
                let h = 1e-6;
                let difference = (gradient(h) - gradient(-h)) / (2.0 * h);
                let exact = region.d2_hessian(&x, &closest) * corners(direction);
                // nearly flat triangles and nearly parallel edges have large
                // third derivatives
                let error = (difference - exact).norm() / (scale + exact.norm());
                assert!(error < 1e-5, "{region:?}: {error:e}");
            }
            assert_eq!(seen.len(), count, "regions visited: {seen:?}");
        }
    }
}

#[test]
fn degenerate_features_are_edges_and_points() {
    for scale in SCALES {
        let v = |x: f64, y: f64, z: f64| Vec3::new(x, y, z) * scale;
        let check = |d2: f64, expected: f64| {
            assert!((d2 / (scale * scale) - expected).abs() < 1e-14, "{d2} {expected}");
        };
        let p = v(0.5, 2.0, 0.0);
        // a triangle without area, with and without length
        check(point_triangle(&[p, v(0., 0., 0.), v(1., 0., 0.), v(2., 0., 0.)]).d2, 4.0);
        check(point_triangle(&[p, v(0.5, 0., 0.), v(0.5, 0., 0.), v(0.5, 0., 0.)]).d2, 4.0);
        // parallel edges side by side, in line, and an edge without length
        let a = [v(0., 0., 0.), v(1., 0., 0.)];
        check(edge_edge(&[a[0], a[1], v(0.5, 1., 0.), v(3., 1., 0.)]).d2, 1.0);
        check(edge_edge(&[a[0], a[1], v(3., 0., 0.), v(4., 0., 0.)]).d2, 4.0);
        check(edge_edge(&[a[0], a[1], p, p]).d2, 4.0);
        check(edge_edge(&[p, p, p, p]).d2, 0.0);
    }
}

/// Edges that are parallel up to rounding must not be taken for crossing
/// ones, however small they are.
#[test]
fn nearly_parallel_edges_have_the_distance_of_parallel_ones() {
    for scale in SCALES {
        for tilt in [1e-18, 1e-12, 1e-9, 1e-6] {
            let x = [
                Vec3::new(0.0, 0.0, 0.0),
                Vec3::new(1.0, 0.0, 0.0),
                Vec3::new(0.2, 0.5, 0.0),
                Vec3::new(0.9, 0.5, tilt),
            ];
            let d = edge_edge(&x.map(|v| v * scale)).d2.sqrt() / scale;
            assert!((d - 0.5).abs() < 1e-12, "tilt {tilt}: {d}");
        }
    }
}
