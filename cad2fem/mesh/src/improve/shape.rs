//! The shape of a tetrahedron and the energy that vertices descend.

use crate::Vec3;
use nalgebra::Matrix3;

/// Cubed mean ratio of a tetrahedron: 1 if regular, 0 if flat, negative if
/// inverted.
///
/// With the sum S of its squared edges the mean ratio is η = 12 (3V)^⅔ / S (Liu,
/// Joe 1994). Its cube orders tetrahedra in the same way and needs no root.
pub(super) fn shape(corners: [Vec3; 4]) -> f64 {
    let [p, q, r] = [1, 2, 3].map(|k| corners[k] - corners[0]);
    let six_volumes = p.dot(&q.cross(&r));
    let squares = p.norm_squared()
        + q.norm_squared()
        + r.norm_squared()
        + (q - p).norm_squared()
        + (r - q).norm_squared()
        + (p - r).norm_squared();
    if squares == 0.0 {
        return 0.0;
    }
    // 12³ (3V)² / S³ with 3V = (6V) / 2.
    432.0 * six_volumes * six_volumes.abs() / (squares * squares * squares)
}

/// A value with its gradient and Hessian with respect to a vertex.
pub(super) struct Energy {
    pub value: f64,
    pub gradient: Vec3,
    pub hessian: Matrix3<f64>,
}

/// Weight of the worst tetrahedra in the energy.
const EXPONENT: i32 = 8;

/// The energy Σ (S / h(V)^⅔)^p of the tetrahedra between vertex `x` and the
/// triangles `link`, which face `x`; none if it is infinite.
///
/// With `slack` = 0, h(V) = V: each term is the inverse mean ratio to the power p,
/// up to a constant. S is a positive quadratic function of x and V is linear, so
/// that S / V^⅔ and its powers are convex where V > 0: there is one minimum and
/// Newton finds it. With a `slack` δ > 0 [6 m³], h = (V + √(V² + 4δ²)) / 2 is
/// positive and increasing for all V, and the descent turns inverted tetrahedra
/// right (Escobar et al. 2003).
pub(super) fn energy(link: &[[Vec3; 3]], x: &Vec3, slack: f64) -> Option<Energy> {
    let p = f64::from(EXPONENT);
    let mut sum = Energy { value: 0.0, gradient: Vec3::zeros(), hessian: Matrix3::zeros() };
    for [a, b, c] in link {
        let normal = (b - a).cross(&(c - a));
        let volume = normal.dot(&(x - a));
        let root = volume.hypot(2.0 * slack);
        // Either form of h, whichever does not cancel.
        let h = if volume > 0.0 {
            (volume + root) / 2.0
        } else {
            2.0 * slack * slack / (root - volume)
        };
        let edges = [x - a, x - b, x - c];
        let opposite = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
        let squares = edges.iter().map(Vec3::norm_squared).sum::<f64>() + opposite;
        let value = (squares / (h * h).cbrt()).powi(EXPONENT);
        if !value.is_finite() {
            return None;
        }
        // Derivatives of p (ln S − ⅔ ln h), then of its exponential; (ln h)' = 1/√,
        // −(ln h)'' = V/√³, kept only where it is convex.
        let ds = 2.0 * (edges[0] + edges[1] + edges[2]) / squares;
        let dh = normal / root;
        let slope = p * (ds - dh * (2.0 / 3.0));
        let bend = (2.0 / 3.0) * (volume / root).max(0.0);
        let curvature = Matrix3::identity() * (6.0 / squares) - ds * ds.transpose()
            + dh * dh.transpose() * bend;
        sum.value += value;
        sum.gradient += slope * value;
        sum.hessian += (curvature * p + slope * slope.transpose()) * value;
    }
    Some(sum)
}

/// The `slack` for a vertex at `x`: none if all tetrahedra are positive, else
/// enough to make the most inverted one count.
pub(super) fn slack(link: &[[Vec3; 3]], x: &Vec3) -> f64 {
    let volumes = link.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).dot(&(x - a)));
    let (lowest, total) =
        volumes.fold((f64::INFINITY, 0.0), |(low, sum), v| (low.min(v), sum + v.abs()));
    if lowest > 0.0 {
        return 0.0;
    }
    let small = 1e-2 * total / link.len() as f64;
    (small * (small - lowest)).sqrt()
}
