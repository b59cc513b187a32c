//! The mollifier of parallel edges: takes a pair of edges out of the potential, smoothly,
//! as they become parallel, because their closest points jump there.
//!
//! m(c, ε) = y (2 − y) for y < 1, else 1,   y = c / ε
//! c = |a × b|²,   ε = 10⁻³ |ā|² |b̄|²
//!
//! a, b   edges;   ā, b̄ the same edges in the rest shape [m], so that ε does not
//!        change with the displacement
//! c, ε   [m⁴]
//!
//! An edge without rest length is mollified only while c = 0 as well.
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, eq. 24.

use mesh::Vec3;

use super::distance::corners;
use crate::math::tensor::{Mat3, Mat12, Vec12};

/// sin² of the angle below which undeformed edges are mollified [1].
const THRESHOLD: f64 = 1e-3;

/// m and its derivatives by c and ε.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mollifier {
    /// m [1].
    pub value: f64,
    /// ∂m/∂c [1/m⁴].
    pub by_cross: f64,
    /// ∂²m/∂c² [1/m⁸].
    pub by_cross_twice: f64,
    /// ∂m/∂ε [1/m⁴].
    pub by_threshold: f64,
    /// ∂²m/∂c∂ε [1/m⁸].
    pub by_both: f64,
}

impl Mollifier {
    /// One, for pairs that are never mollified.
    pub const ONE: Self = Self::constant(1.0);

    const fn constant(value: f64) -> Self {
        Self { value, by_cross: 0.0, by_cross_twice: 0.0, by_threshold: 0.0, by_both: 0.0 }
    }

    /// m at c and ε.
    pub fn new(cross: f64, threshold: f64) -> Self {
        if threshold == 0.0 || cross >= threshold {
            return Self::constant(if cross > 0.0 { 1.0 } else { 0.0 });
        }
        let y = cross / threshold;
        let square = threshold * threshold;
        Self {
            value: y * (2.0 - y),
            by_cross: 2.0 * (1.0 - y) / threshold,
            by_cross_twice: -2.0 / square,
            by_threshold: 2.0 * y * (y - 1.0) / threshold,
            by_both: 2.0 * (2.0 * y - 1.0) / square,
        }
    }
}

/// Whether edges `x[0..2]` and `x[2..4]` are so parallel that they are mollified.
pub fn mollified(x: &[Vec3; 4], rest: &[Vec3; 4]) -> bool {
    let cross = cross(x);
    cross < threshold(rest) || cross == 0.0
}

/// c [m⁴].
pub fn cross(x: &[Vec3; 4]) -> f64 {
    (x[1] - x[0]).cross(&(x[3] - x[2])).norm_squared()
}

/// ∂c/∂xᵢ [m³].
pub fn cross_gradient(x: &[Vec3; 4]) -> Vec12 {
    let (a, b) = (x[1] - x[0], x[3] - x[2]);
    let n = a.cross(&b);
    of_edges(2.0 * b.cross(&n), 2.0 * n.cross(&a))
}

/// ∂²c/∂xᵢ∂xⱼ [m²].
pub fn cross_hessian(x: &[Vec3; 4]) -> Mat12 {
    let (a, b) = (x[1] - x[0], x[3] - x[2]);
    let dyad = |p: &Vec3, q: &Vec3| p * q.transpose();
    let square = |p: &Vec3| 2.0 * (Mat3::identity() * p.norm_squared() - dyad(p, p));
    let mixed = 4.0 * dyad(&a, &b) - 2.0 * dyad(&b, &a) - Mat3::identity() * (2.0 * a.dot(&b));
    let (by_a, by_b) = (square(&b), square(&a));
    let mut hessian = Mat12::zeros();
    for i in 0..4 {
        for j in 0..4 {
            let block = match (i / 2, j / 2) {
                (0, 0) => by_a,
                (0, _) => mixed,
                (_, 0) => mixed.transpose(),
                _ => by_b,
            };
            let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
            hessian.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&(sign * block));
        }
    }
    hessian
}

/// ε of rest positions [m⁴].
pub fn threshold(rest: &[Vec3; 4]) -> f64 {
    THRESHOLD * (rest[1] - rest[0]).norm_squared() * (rest[3] - rest[2]).norm_squared()
}

/// ∂ε/∂Xᵢ [m³].
pub fn threshold_gradient(rest: &[Vec3; 4]) -> Vec12 {
    let (a, b) = (rest[1] - rest[0], rest[3] - rest[2]);
    let by = 2.0 * THRESHOLD;
    of_edges(a * (by * b.norm_squared()), b * (by * a.norm_squared()))
}

/// A derivative by the corners from those by the two edges.
fn of_edges(by_a: Vec3, by_b: Vec3) -> Vec12 {
    corners([-by_a, by_a, -by_b, by_b])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives belong to the energy of [`Contact`](crate::energy::Contact), beside which they are tested.
    #[test]
    fn the_mollifier_ends_smoothly_and_without_rest_length() {
        let e = 3e-7;
        assert_eq!(Mollifier::new(e, e), Mollifier::ONE);
        assert!(Mollifier::new(e * (1.0 - 1e-9), e).by_cross < 1e-8 / e, "m is C¹");
        assert_eq!(Mollifier::new(0.0, 0.0).value, 0.0);
        assert_eq!(Mollifier::new(1e-30, 0.0), Mollifier::ONE);
    }
}
