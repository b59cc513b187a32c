//! Squared distances between two features given by four points.
//!
//! d² = |r|²,   r = Σᵢ cᵢ xᵢ,   Σᵢ cᵢ = 0
//!
//! x   corners of both features [m]
//! c   barycentric coefficients of the two closest points, negative for the
//!     second feature [1]
//! r   vector from the closest point of the second feature to that of the
//!     first [m]
//!
//! The coefficients minimise |r| under bounds, so their change does not show in
//! the first derivative: ∂d²/∂xᵢ = 2 cᵢ r. A coefficient that is exactly zero
//! marks a corner that the closest feature does not contain. Degenerate
//! features (a triangle without area, an edge without length) are treated as
//! the edges or the point that they are. Thresholds are relative, so results do
//! not depend on the unit of length.
//!
//! Within a region, that is as long as the same corners take part, c = c⁰ + Σ sₖ eₖ
//! with free s, and ∂d²/∂s = 0 gives s and its change with x:
//!
//! ∂²d²/∂x² = 2 (c cᵀ ⊗ I − G M⁻¹ Gᵀ)      Gₖ = c ⊗ tₖ + eₖ ⊗ r
//! tₖ = Σᵢ eᵢₖ xᵢ      Mₖₗ = tₖ · tₗ
//!
//! d² is once continuously differentiable, except for edges that are parallel
//! and side by side, where the closest points are not unique; see
//! [`mollifier`](super::mollifier).

use mesh::Vec3;

use crate::math::tensor::{Mat12, Vec12};

/// sin² of the angle below which two directions count as parallel [1].
const PARALLEL: f64 = 2.5e-16;

/// The closest points of two features.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// cᵢ of the four corners [1].
    pub coefficients: [f64; 4],
    /// r, from the second feature to the first [m].
    pub offset: Vec3,
    /// d² [m²].
    pub d2: f64,
}

impl Closest {
    fn new(x: &[Vec3; 4], coefficients: [f64; 4]) -> Self {
        // differences to one corner first, so that an offset common to all
        // corners costs no digits
        let offset = (1..4).map(|i| coefficients[i] * (x[i] - x[0])).sum::<Vec3>();
        Self { coefficients, offset, d2: offset.norm_squared() }
    }

    /// ∂d²/∂xᵢ [m].
    #[must_use]
    pub fn d2_gradient(&self) -> [Vec3; 4] {
        self.coefficients.map(|c| 2.0 * c * self.offset)
    }

    fn closer(self, other: Self) -> Self {
        if other.d2 < self.d2 { other } else { self }
    }
}

/// Which corners of two features their closest points lie between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Region {
    /// Number of corners of the first feature: 1 for a point, 2 for an edge.
    pub first: usize,
    /// Whether each of the four corners takes part.
    pub active: [bool; 4],
}

impl Region {
    /// The region of closest points.
    #[must_use]
    pub fn of(first: usize, closest: &Closest) -> Self {
        Self { first, active: closest.coefficients.map(|c| c != 0.0) }
    }

    /// The closest points if they are in this region.
    #[must_use]
    pub fn closest(&self, x: &[Vec3; 4]) -> Closest {
        let free = self.free();
        let mut c = free.start;
        let r: Vec3 = c.iter().zip(x).map(|(c, p)| *c * (p - x[0])).sum();
        let s = match (free.count, free.tangents(x)) {
            (0, _) => [0.0; 2],
            (1, [t, _]) => [-t.dot(&r) / t.norm_squared(), 0.0],
            (_, [a, b]) => {
                let n = a.cross(&b);
                [b.cross(&r).dot(&n), r.cross(&a).dot(&n)].map(|v| v / n.norm_squared())
            }
        };
        for (e, s) in free.directions.iter().zip(s) {
            c.iter_mut().zip(e).for_each(|(c, e)| *c += s * e);
        }
        Closest::new(x, c)
    }

    /// ∂²d²/∂x² at the closest points, which are in this region [1].
    #[must_use]
    pub fn d2_hessian(&self, x: &[Vec3; 4], closest: &Closest) -> Mat12 {
        let c = &closest.coefficients;
        let mut hessian = Mat12::zeros();
        for i in 0..4 {
            for j in 0..4 {
                let mut block = hessian.fixed_view_mut::<3, 3>(3 * i, 3 * j);
                block.fill_diagonal(2.0 * c[i] * c[j]);
            }
        }
        let free = self.free();
        let t = free.tangents(x);
        let g: [Vec12; 2] = std::array::from_fn(|k| {
            let of_corner = |i: usize| c[i] * t[k] + free.directions[k][i] * closest.offset;
            corners([0, 1, 2, 3].map(of_corner))
        });
        let (aa, ab, bb) = (t[0].norm_squared(), t[0].dot(&t[1]), t[1].norm_squared());
        match free.count {
            0 => {}
            1 => hessian -= g[0] * (g[0] * (2.0 / aa)).transpose(),
            _ => {
                let by = 2.0 / t[0].cross(&t[1]).norm_squared();
                hessian -= g[0] * ((g[0] * bb - g[1] * ab) * by).transpose();
                hessian -= g[1] * ((g[1] * aa - g[0] * ab) * by).transpose();
            }
        }
        hessian
    }

    fn free(&self) -> Free {
        let mut free = Free { start: [0.0; 4], directions: [[0.0; 4]; 2], count: 0 };
        let mut base = [None; 2];
        for i in (0..4).filter(|&i| self.active[i]) {
            let (feature, sign) = if i < self.first { (0, 1.0) } else { (1, -1.0) };
            if let Some(base) = base[feature] {
                free.directions[free.count][i] = sign;
                free.directions[free.count][base] = -sign;
                free.count += 1;
            } else {
                free.start[i] = sign;
                base[feature] = Some(i);
            }
        }
        free
    }
}

/// c⁰ and the directions eₖ, at most two, in which the coefficients are free.
struct Free {
    start: [f64; 4],
    directions: [[f64; 4]; 2],
    count: usize,
}

impl Free {
    /// tₖ, zero from the number of directions on.
    fn tangents(&self, x: &[Vec3; 4]) -> [Vec3; 2] {
        self.directions.map(|e| e.iter().zip(x).map(|(e, p)| *e * (p - x[0])).sum())
    }
}

/// One vector of the components of four.
#[must_use]
pub fn corners(vectors: [Vec3; 4]) -> Vec12 {
    Vec12::from_fn(|i, _| vectors[i / 3][i % 3])
}

/// Point `x[0]` to triangle `x[1..4]`.
#[must_use]
pub fn point_triangle(x: &[Vec3; 4]) -> Closest {
    if let Some([a, b]) = projection(x) {
        return Closest::new(x, [1.0, a + b - 1.0, -a, -b]);
    }
    let edge = |i: usize, j: usize| point_edge(x, 0, [i, j]);
    edge(1, 2).closer(edge(2, 3)).closer(edge(3, 1))
}

/// Corner `point` to the edge of corners i and j of the other feature.
#[must_use]
pub fn point_edge(x: &[Vec3; 4], point: usize, [i, j]: [usize; 2]) -> Closest {
    let t = segment_parameter(&x[point], &x[i], &x[j]);
    let sign = if point < i { 1.0 } else { -1.0 };
    let mut c = [0.0; 4];
    c[point] = sign;
    c[i] = -sign * (1.0 - t);
    c[j] = -sign * t;
    Closest::new(x, c)
}

/// Edge `x[0..2]` to edge `x[2..4]`.
#[must_use]
pub fn edge_edge(x: &[Vec3; 4]) -> Closest {
    if let Some([s, t]) = crossing(x) {
        return Closest::new(x, [1.0 - s, s, t - 1.0, -t]);
    }
    point_edge(x, 0, [2, 3])
        .closer(point_edge(x, 1, [2, 3]))
        .closer(point_edge(x, 2, [0, 1]))
        .closer(point_edge(x, 3, [0, 1]))
}

/// Parameter in [0, 1] of the point of segment `a`–`b` closest to `p`.
fn segment_parameter(p: &Vec3, a: &Vec3, b: &Vec3) -> f64 {
    let edge = b - a;
    let length2 = edge.norm_squared();
    if length2 == 0.0 { 0.0 } else { ((p - a).dot(&edge) / length2).clamp(0.0, 1.0) }
}

/// Barycentric coordinates of corners 2 and 3 at the projection of the point
/// onto the plane of the triangle, if it lies strictly inside.
fn projection(x: &[Vec3; 4]) -> Option<[f64; 2]> {
    let (e1, e2, q) = (x[2] - x[1], x[3] - x[1], x[0] - x[1]);
    let n = e1.cross(&e2);
    let n2 = n.norm_squared();
    if n2 <= PARALLEL * e1.norm_squared() * e2.norm_squared() {
        return None;
    }
    let (a, b) = (q.cross(&e2).dot(&n) / n2, e1.cross(&q).dot(&n) / n2);
    (a > 0.0 && b > 0.0 && a + b < 1.0).then_some([a, b])
}

/// Parameters of the closest points of the two lines, if both lie strictly
/// inside the segments and the lines are not parallel.
fn crossing(x: &[Vec3; 4]) -> Option<[f64; 2]> {
    let (a, b, w) = (x[1] - x[0], x[3] - x[2], x[2] - x[0]);
    let n = a.cross(&b);
    let n2 = n.norm_squared();
    if n2 <= PARALLEL * a.norm_squared() * b.norm_squared() {
        return None;
    }
    let (s, t) = (w.cross(&b).dot(&n) / n2, w.cross(&a).dot(&n) / n2);
    let inside = |v: f64| v > 0.0 && v < 1.0;
    (inside(s) && inside(t)).then_some([s, t])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::mollifier::faded;
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

    /// Every choice of "closest corners": value, and gradient against central
    /// differences, at three scales.
    #[test]
    fn every_region_has_the_gradient_of_its_distance() {
        let mut random = Random::new(2);
        for scale in SCALES {
            for (expected, distance) in [(7, point_triangle as Distance), (9, edge_edge)] {
                let mut seen = std::collections::BTreeSet::new();
                for _ in 0..600 {
                    let x = random_corners(&mut random).map(|v| v * scale);
                    let closest = distance(&x);
                    seen.insert(closest.coefficients.map(|c| c != 0.0));
                    check_gradient(&x, distance, scale);
                }
                assert_eq!(seen.len(), expected, "regions visited: {seen:?}");
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

    /// A corner travels on a straight line through many regions. Wherever the
    /// region changes, the gradients on both sides of the border agree.
    #[test]
    fn distance_is_continuously_differentiable_across_regions() {
        let mut random = Random::new(3);
        for scale in SCALES {
            for distance in [point_triangle as Distance, edge_edge] {
                let mut borders = 0;
                for _ in 0..100 {
                    let start = random_corners(&mut random).map(|v| v * scale);
                    let velocity = random.vector() * 4.0 * scale;
                    let at = |t: f64| {
                        let mut x = start;
                        x[0] += velocity * (t - 0.5);
                        x
                    };
                    for step in 0..100 {
                        let t = f64::from(step) / 100.0;
                        borders += usize::from(check_border(&at, distance, t, t + 0.01, scale));
                    }
                }
                assert!(borders > 100, "only {borders} borders crossed");
            }
        }
    }

    /// Bisects to the border of two regions between `from` and `to`, if there
    /// is one and the pair is not faded there.
    fn check_border(
        at: &dyn Fn(f64) -> [Vec3; 4],
        distance: Distance,
        mut from: f64,
        mut to: f64,
        scale: f64,
    ) -> bool {
        let region = |t: f64| distance(&at(t)).coefficients.map(|c| c != 0.0);
        let start = region(from);
        if region(to) == start || faded(&at(from), &at(from)) {
            return false;
        }
        while to - from > 1e-13 {
            let middle = 0.5 * (from + to);
            if region(middle) == start { from = middle } else { to = middle }
        }
        let [a, b] = [from, to].map(|t| distance(&at(t)).d2_gradient());
        // candidates whose parameters differ by √(10⁻¹⁶) have equal distances
        // to rounding, so that either may be taken
        assert!((0..4).all(|i| (a[i] - b[i]).norm() < 1e-6 * scale), "{a:?} {b:?}");
        true
    }

    /// Second derivatives of every region against differences of the gradient,
    /// and the region's own closest points against the clamped ones.
    #[test]
    fn every_region_has_the_hessian_of_its_distance() {
        let mut random = Random::new(12);
        for scale in SCALES {
            for (first, count, distance) in [(1, 7, point_triangle as Distance), (2, 9, edge_edge)]
            {
                let mut seen = std::collections::BTreeSet::new();
                for _ in 0..600 {
                    let x = random_corners(&mut random).map(|v| v * scale);
                    let closest = distance(&x);
                    let region = Region::of(first, &closest);
                    let again = region.closest(&x);
                    assert!((again.d2 - closest.d2).abs() < 1e-11 * scale * scale);
                    seen.insert(region);
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
}
